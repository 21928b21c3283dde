//! The jobs for which power is measured: random ones, and those of a picture, a search and recorded transactions.

use crate::commands::full::render::Shown;
use crate::commands::full::{MemoryArguments, watched};
use crate::{CliError, whole};
use clap::Args;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use raypath_model::{OperationId, WordModel, Words};
use raypath_ops::JobKind;
use raypath_render::{PictureSpec, Shading, Tracing, picture_jobs};
use raypath_rtl::{Config, Lanes};
use raypath_search::{Clusters, Metric, Vectors, distance_jobs, read_vectors};
use raypath_sim::jobs;
use raypath_sim::transactions;
use raypath_timing::{Environment, Sample, System};
use std::path::PathBuf;

/// The default number of jobs in a stream.
const STREAM: usize = 256;
/// The default seed.
const SEED: u64 = 1;

#[derive(Debug, Args)]
pub struct JobArguments {
    /// The scene of the measured picture: a mesh as .obj, .gltf, .glb, .ply or .stl [default: a built-in one]
    #[arg(long, requires = "power", value_name = "FILE")]
    scene: Option<PathBuf>,
    /// The vectors of the measured search: .fvecs, .bvecs, .ivecs or .npy [default: generated vectors]
    #[arg(long, requires = "power", value_name = "FILE")]
    vectors: Option<PathBuf>,
    /// Measure the power of recorded transactions too; may be given several times
    #[arg(long, requires = "power", value_name = "FILE")]
    recorded: Vec<PathBuf>,
    /// The number of jobs in each of the 64 streams
    #[arg(long, requires = "power", default_value_t = STREAM, value_parser = whole(16..=100_000usize), value_name = "N")]
    pub stream: usize,
    /// Seed of random jobs
    #[arg(long, requires = "power", default_value_t = SEED, value_parser = whole(0..=u64::MAX))]
    seed: u64,
    #[command(flatten)]
    memory: MemoryArguments,
}

/// Named jobs, offered back to back.
pub struct Jobs {
    pub name: String,
    pub jobs: Vec<Words>,
}

/// The picture whose jobs are measured, and its sampled pixels.
const PICTURE: (u32, u32) = (640, 480);
const PIXELS: usize = 1024;
/// The first vectors of a file are searched, for the queries after them.
const VECTORS: usize = 1000;
const QUERIES: usize = 8;

impl JobArguments {
    /// The defaults: the built-in picture, and generated vectors.
    pub fn built_in() -> Self {
        Self {
            scene: None,
            vectors: None,
            recorded: Vec::new(),
            stream: STREAM,
            seed: SEED,
            memory: MemoryArguments::default(),
        }
    }

    /// All jobs that the operations of the model have; `count` random ones of each.
    pub fn jobs(&self, model: &WordModel, config: Config, count: usize) -> Result<Vec<Jobs>, CliError> {
        let mut all: Vec<Jobs> =
            model.kinds().into_iter().map(|kind| self.random(model, config, kind, count)).collect();
        let has = |kind: JobKind| model.kind(kind.name()).is_some();
        if has(JobKind::Quadbox) && has(JobKind::Triangle) {
            let picture = self.picture(model, config)?;
            for kind in [JobKind::Quadbox, JobKind::Triangle] {
                let of_kind = picture.iter().filter(|job| job.kind().paper() == Some(kind)).cloned().collect();
                all.push(Jobs { name: format!("{} of the picture", kind.name()), jobs: of_kind });
            }
            all.push(Jobs { name: "picture".to_string(), jobs: picture });
        }
        for (kind, metric) in [(JobKind::Euclidean, Metric::Euclidean), (JobKind::Angular, Metric::Angular)] {
            if has(kind) {
                all.push(Jobs {
                    name: format!("{} of the search", kind.name()),
                    jobs: self.search(model, config, metric)?,
                });
            }
        }
        for path in &self.recorded {
            let recorded = transactions::read(path, None, model, config)?;
            let jobs = recorded.into_iter().map(|transaction| transaction.job).collect();
            all.push(Jobs { name: path.display().to_string(), jobs });
        }
        Ok(all.into_iter().filter(|jobs| !jobs.jobs.is_empty()).collect())
    }

    fn random(&self, model: &WordModel, config: Config, kind: OperationId, count: usize) -> Jobs {
        let jobs = match kind.paper() {
            Some(paper) => jobs::random(model, config.semantics.format, self.seed, &[paper]).take(count).collect(),
            None => {
                let mut random = ChaCha8Rng::seed_from_u64(self.seed);
                (0..count).map(|_| jobs::any_job(model, kind, &mut random)).collect()
            }
        };
        Jobs { name: format!("{}, random", kind.name()), jobs }
    }

    /// The jobs of the picture.
    pub fn picture(&self, model: &WordModel, config: Config) -> Result<Vec<Words>, CliError> {
        let shown = Shown::read(self.scene.as_deref(), None, self.memory.limit)?;
        let camera = shown.framing(PICTURE.0 as f32 / PICTURE.1 as f32);
        let scene = shown.scene([camera.eye()])?;
        let tracing = Tracing { rules: config.semantics.rules_in_full(), ..Tracing::default() };
        let shading = Shading { tracing, shadows: true, ..Shading::default() };
        let spec = PictureSpec { scene: &scene, camera, size: PICTURE, shading };
        let sample = Sample::spread((PICTURE.0 * PICTURE.1) as usize, PIXELS);
        let system =
            System { environment: Environment { in_flight: 256, ..Environment::default() }, ..System::default() };
        let jobs = watched("pixels", PIXELS, |progress| picture_jobs(&spec, sample, &system, progress))?;
        Ok(jobs.iter().filter_map(|job| model.paper_job(job)).collect())
    }

    fn search(&self, model: &WordModel, config: Config, metric: Metric) -> Result<Vec<Words>, CliError> {
        match config.semantics.lanes {
            Lanes::None => Ok(Vec::new()),
            Lanes::Two => self.search_in::<2, 1>(model, metric),
            Lanes::Four => self.search_in::<4, 2>(model, metric),
            Lanes::Eight => self.search_in::<8, 4>(model, metric),
            Lanes::Sixteen => self.search_in::<16, 8>(model, metric),
            Lanes::ThirtyTwo => self.search_in::<32, 16>(model, metric),
            Lanes::SixtyFour => self.search_in::<64, 32>(model, metric),
        }
    }

    fn search_in<const E: usize, const A: usize>(
        &self,
        model: &WordModel,
        metric: Metric,
    ) -> Result<Vec<Words>, CliError> {
        let (base, queries) = self.searched()?;
        let jobs = distance_jobs::<E, A>(&base, &queries, metric).map_err(CliError::unusable)?;
        Ok(jobs.iter().filter_map(|job| model.paper_job(job)).collect())
    }

    /// The vectors to search, and the queries.
    fn searched(&self) -> Result<(Vectors, Vectors), CliError> {
        let Some(path) = &self.vectors else {
            let clusters = Clusters { vectors: VECTORS, queries: QUERIES, seed: self.seed, ..Clusters::default() };
            let dataset = clusters.generate().map_err(CliError::unusable)?;
            return Ok((dataset.base, dataset.queries));
        };
        let all = read_vectors(path, self.memory.limit).map_err(CliError::unusable)?;
        if all.len() < 2 {
            let problem = format!("{}: {} vectors, expected at least 2", path.display(), all.len());
            return Err(CliError::unusable(problem));
        }
        let queries = QUERIES.min(all.len() / 2);
        let base = VECTORS.min(all.len() - queries);
        let part = |range: std::ops::Range<usize>| {
            let numbers = range.filter_map(|number| all.get(number)).flatten().copied().collect();
            Vectors::new(all.dimensions(), numbers).map_err(CliError::unusable)
        };
        Ok((part(0..base)?, part(base..base + queries)?))
    }
}
