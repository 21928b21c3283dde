//! `raypath render`: rendering of a mesh with the operations of the datapath, and its simulated timing.

mod divided;
mod scene;
mod timing;
mod unit;

use crate::commands::full::{DivisionArguments, MemoryArguments, write_and_name};
use crate::{CliError, ConfigArguments, whole};
use clap::{Args, ValueEnum};
use divided::Divided;
use raypath_float::Format;
use raypath_ops::{Binary32, Ray, Rounding};
use raypath_render::{
    Counts, Hit, PictureSpec, RayBatch, Rendering, Scene, Shading, Tracing, UnitSystem, draw, read_hits, read_rays,
    to_png, write_hits, write_rays,
};
use raypath_rtl::Config;
use raypath_timing::report::Image;
use scene::CameraArguments;
pub use scene::Shown;
use std::io::Write;
use std::path::{Path, PathBuf};
use timing::{Simulated, Timed, TimingArguments, Work};
use unit::UnitTimingArguments;

#[derive(Debug, Args)]
pub struct Arguments {
    /// The scene: a mesh as .obj, .gltf, .glb, .ply or .stl [default: a built-in one]
    scene: Option<PathBuf>,
    /// Show the mesh at several places: a file with 12 numbers a line, of an affine matrix from the mesh to the scene,
    /// row by row; with --through unit or --draw
    #[arg(long, value_name = "FILE")]
    instances: Option<PathBuf>,
    #[command(flatten)]
    camera: CameraArguments,
    /// Size of the picture in pixels
    #[arg(long, default_value = "640x480", value_parser = scene::size, value_name = "WIDTHxHEIGHT")]
    size: (u32, u32),
    /// Trace a shadow ray from each hit towards the sun
    #[arg(long)]
    shadows: bool,
    /// Ambient-occlusion rays per hit
    #[arg(long, default_value_t = 0, value_parser = whole(0..=4096u32), value_name = "N")]
    ao: u32,
    /// Samples per pixel along each axis: a pixel is the mean of N x N rays
    #[arg(long, default_value_t = 1, value_parser = whole(1..=64u32), value_name = "N")]
    samples: u32,
    /// Hit triangles from behind too, with a second job for each
    #[arg(long)]
    two_sided: bool,
    /// What traces the rays: the jobs of the datapath, with a traversal in software, or the models of the traversal
    /// unit
    #[arg(long, default_value = "datapath", value_name = "datapath|unit")]
    through: Through,
    /// Seed of ambient-occlusion rays
    #[arg(long, default_value_t = 1, value_parser = whole(0..=u64::MAX))]
    seed: u64,
    /// The picture to write
    #[arg(long, default_value = "build/image.png", value_name = "FILE.png")]
    out: PathBuf,
    /// Write a heat map of the jobs per pixel
    #[arg(long, value_name = "FILE.png", conflicts_with = "rays")]
    heatmap: Option<PathBuf>,
    /// Trace the rays of a file instead of rendering a picture: origin, direction and extent per line
    #[arg(long, value_name = "FILE", conflicts_with_all = ["camera", "size", "shadows", "ao", "samples", "out"])]
    rays: Option<PathBuf>,
    /// Write the hits of --rays or of the rays through pixel centres: triangle, t, t_num, t_denom, and the bits of the
    /// three [default: print the hits of --rays]
    #[arg(long, value_name = "FILE")]
    hits: Option<PathBuf>,
    /// Write the rays through pixel centres, in the form of --rays
    #[arg(long, value_name = "FILE", conflicts_with = "rays")]
    camera_rays: Option<PathBuf>,
    /// Draw the picture from the hits of a file, in the form of --hits, instead of tracing: a line for each pixel
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with_all = ["rays", "hits", "shadows", "ao", "samples", "heatmap", "two_sided", "through", "camera_rays"]
    )]
    draw: Option<PathBuf>,
    /// Rays in flight in the simulation; the rays of a pixel follow one another [default: 256; with --through unit twice
    /// its contexts]
    #[arg(long, conflicts_with = "no_timing", value_parser = whole(1..=1usize << 20), value_name = "R")]
    rays_in_flight: Option<usize>,
    /// Simulate N evenly spaced pixels, or rays of --rays
    #[arg(long, default_value_t = 50_000, value_parser = whole(1..=usize::MAX), value_name = "N")]
    timed: usize,
    #[command(flatten)]
    timing: TimingArguments,
    #[command(flatten)]
    unit: UnitTimingArguments,
    #[command(flatten)]
    memory: MemoryArguments,
    #[command(flatten)]
    division: DivisionArguments,
    #[command(flatten)]
    config: ConfigArguments,
}

/// The default number of rays in flight through the datapath.
const RAYS_IN_FLIGHT: usize = 256;

/// What traces the rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Through {
    Datapath,
    Unit,
}

impl Through {
    /// The scene, in memory if the unit traces its rays.
    fn scene(
        self,
        shown: Shown,
        origins: impl IntoIterator<Item = [f32; 3]>,
        unit: &UnitTimingArguments,
    ) -> Result<Scene, CliError> {
        match self {
            Self::Datapath => shown.scene(origins),
            Self::Unit => shown.through_unit(origins, unit.nodes()),
        }
    }
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let config = arguments.config.paper()?;
    if config.semantics.format != Format::BINARY32 {
        let problem = format!("--format {}: scenes are traced in fp32 only", config.semantics.format);
        return Err(CliError::unusable(problem));
    }
    if config.semantics.rounding != Rounding::Unit {
        let problem = format!("--rounding {}: scenes are traced with rounding unit only", config.semantics.rounding);
        return Err(CliError::unusable(problem));
    }
    let system = arguments.unit_system(config)?;
    let tracing = Tracing { rules: config.semantics.rules_in_full(), two_sided: arguments.two_sided };
    if let Some(hits) = &arguments.draw {
        return drawn(arguments, hits, out);
    }
    match &arguments.rays {
        Some(path) => {
            let rays = read_rays(path, arguments.memory.limit).map_err(CliError::unusable)?;
            if rays.is_empty() {
                return Err(CliError::unusable(format!("{}: no rays, expected at least one", path.display())));
            }
            trace(arguments, config, system, tracing, rays, out)
        }
        None => picture(arguments, config, system, tracing, out),
    }
}

fn picture(
    arguments: &Arguments,
    config: Config,
    system: Option<UnitSystem>,
    tracing: Tracing,
    out: &mut dyn Write,
) -> Result<(), CliError> {
    let shown = arguments.shown()?;
    let (width, height) = arguments.size;
    let camera = arguments.camera.camera(&shown, width as f32 / height as f32)?;
    let scene = arguments.through.scene(shown, [camera.eye()], &arguments.unit)?;
    scene::describe(arguments.scene.as_deref(), &scene, out)?;
    let shading = Shading {
        tracing,
        shadows: arguments.shadows,
        ambient_occlusion: arguments.ao,
        samples: arguments.samples,
        seed: arguments.seed,
    };
    let mut divided = Divided::begin(&arguments.division, arguments.work(&scene, config))?;
    let rendering = divided.render(&scene, &camera, (width, height), &shading)?;
    let seconds = divided.seconds();
    let hits = match arguments.hits {
        Some(_) => divided.trace(&scene, &camera.rays(width, height).map_err(CliError::unusable)?, tracing)?,
        None => Vec::new(),
    };
    let written = divided.write()?;
    let Some(rendering) = rendering else { return Ok(writeln!(out, "{}", written.unwrap_or_default())?) };
    costs(&rendering, seconds, out)?;
    let png = to_png(&rendering.picture).map_err(CliError::unusable)?;
    let mut files = vec![(arguments.out.clone(), png.clone())];
    if let Some(path) = &arguments.heatmap {
        files.push((path.clone(), to_png(&rendering.heatmap()).map_err(CliError::unusable)?));
    }
    if let Some(path) = &arguments.hits {
        files.push((path.clone(), text(&hits)?));
    }
    if let Some(path) = &arguments.camera_rays {
        let mut text = Vec::new();
        write_rays(&mut text, &camera.rays(width, height).map_err(CliError::unusable)?)?;
        files.push((path.clone(), text));
    }
    let rays = [rendering.primary, rendering.shadow, rendering.occlusion].iter().map(|costs| costs.rays).sum();
    let work = Work::Picture { spec: PictureSpec { scene: &scene, camera, size: (width, height), shading }, rays };
    time(arguments, config, system, work, Some(png), &mut files, out)?;
    write_and_name(&files, out)
}

/// The picture of hits that were traced elsewhere.
fn drawn(arguments: &Arguments, hits: &Path, out: &mut dyn Write) -> Result<(), CliError> {
    let hits = read_hits(hits, arguments.memory.limit).map_err(CliError::unusable)?;
    let shown = arguments.shown()?;
    let (width, height) = arguments.size;
    let camera = arguments.camera.camera(&shown, width as f32 / height as f32)?;
    let scene = shown.scene([camera.eye()])?;
    let picture = draw(&scene, &camera, arguments.size, &hits).map_err(CliError::unusable)?;
    let png = to_png(&picture).map_err(CliError::unusable)?;
    writeln!(out, "{} pixels, {} with a hit", hits.len(), hits.iter().flatten().count())?;
    write_and_name(&[(arguments.out.clone(), png)], out)
}

fn trace(
    arguments: &Arguments,
    config: Config,
    system: Option<UnitSystem>,
    tracing: Tracing,
    rays: Vec<Ray<Binary32>>,
    out: &mut dyn Write,
) -> Result<(), CliError> {
    let shown = arguments.shown()?;
    let origins = rays.iter().map(|ray| ray.origin.into());
    let scene = arguments.through.scene(shown, origins, &arguments.unit)?;
    let mut divided = Divided::begin(&arguments.division, arguments.work(&scene, config))?;
    let hits = divided.trace(&scene, &rays, tracing)?;
    let seconds = divided.seconds();
    if let Some(message) = divided.write()? {
        return Ok(writeln!(out, "{message}")?);
    }
    let wants_pictures = arguments.timing.view.is_wanted() || arguments.timing.has_sweep();
    if arguments.hits.is_none() && !wants_pictures {
        out.write_all(&text(&hits)?)?;
        return Ok(());
    }
    scene::describe(arguments.scene.as_deref(), &scene, out)?;
    let hit = hits.iter().flatten().count();
    writeln!(out, "{} rays, {hit} hits, {seconds:.3} s", rays.len())?;
    let mut files = Vec::new();
    if let Some(path) = &arguments.hits {
        files.push((path.clone(), text(&hits)?));
    }
    let work = Work::Rays(RayBatch { scene: &scene, rays: &rays, tracing });
    time(arguments, config, system, work, None, &mut files, out)?;
    write_and_name(&files, out)
}

/// Simulates the work, prints the results, and adds the requested files to `files`.
fn time(
    arguments: &Arguments,
    config: Config,
    system: Option<UnitSystem>,
    work: Work<'_>,
    png: Option<Vec<u8>>,
    files: &mut Vec<(PathBuf, Vec<u8>)>,
    out: &mut dyn Write,
) -> Result<(), CliError> {
    if arguments.through == Through::Unit {
        if let Some(system) = system {
            files.extend(unit::time(&work, &system, arguments.timed, &arguments.timing, out)?);
        }
        return Ok(());
    }
    let name = scene::name(arguments.scene.as_deref());
    let subject = &Simulated { name, work, max: arguments.timed };
    let timed = arguments.timing.run(subject, arguments.rays_in_flight.unwrap_or(RAYS_IN_FLIGHT), config, out)?;
    if let Some(Timed { mut recording, files: more }) = timed {
        recording.image = png.map(|png| Image { title: "The picture".to_string(), png });
        files.extend(more);
        files.extend(arguments.timing.view.files(&recording));
    }
    Ok(())
}

impl Arguments {
    /// What the scene shows. The traversal in software has no instances.
    fn shown(&self) -> Result<Shown, CliError> {
        if self.instances.is_some() && self.through == Through::Datapath && self.draw.is_none() {
            return Err(CliError::unusable("--instances is an option of --through unit, and of --draw"));
        }
        Shown::read(self.scene.as_deref(), self.instances.as_deref(), self.memory.limit)
    }

    /// The simulated unit; `None` if the rays do not go through it, or without timing.
    fn unit_system(&self, config: Config) -> Result<Option<UnitSystem>, CliError> {
        if self.through == Through::Datapath {
            return self.unit.expect_none().map(|()| None);
        }
        if let Some(rays) = self.rays_in_flight {
            let problem = format!("--rays-in-flight {rays}: with --through unit, expected --contexts");
            return Err(CliError::unusable(problem));
        }
        if self.timing.view.is_wanted() {
            let problem = "--through unit: it has no timeline of jobs, so there is no --report and no --konata";
            return Err(CliError::unusable(problem));
        }
        self.timing.memory_latency().map(|latency| self.unit.system(config, latency)).transpose()
    }

    /// What is rendered or traced, for the parts of several machines. The scene may have another path on each.
    fn work(&self, scene: &Scene, config: Config) -> String {
        let Self { camera, size, shadows, ao, samples, two_sided, seed, rays, hits, .. } = self;
        let (triangles, rays, hits) = (scene.mesh().triangles().len(), rays.is_some(), hits.is_some());
        let instances = scene.instances();
        format!(
            "render {triangles} triangles, {instances} instances, {camera:?}, \
             size {size:?}, shadows {shadows}, ao {ao}, samples {samples}, \
             two-sided {two_sided}, seed {seed}, rays {rays}, hits {hits}, {config}"
        )
    }
}

fn text(hits: &[Option<Hit>]) -> Result<Vec<u8>, CliError> {
    let mut text = Vec::new();
    write_hits(&mut text, hits)?;
    Ok(text)
}

fn costs(rendering: &Rendering, seconds: f64, out: &mut dyn Write) -> Result<(), CliError> {
    let kinds =
        [("from the eye", rendering.primary), ("to the sun", rendering.shadow), ("to the sky", rendering.occlusion)];
    writeln!(
        out,
        "{:<14} {:>10} {:>10} {:>11} {:>11} {:>11} {:>11} {:>10}",
        "rays", "all", "hits", "box jobs", "triangles", "behind", "node reads", "leaf reads"
    )?;
    for (name, costs) in kinds.iter().filter(|(_, costs)| costs.rays > 0) {
        let Counts { quadbox, triangle, behind, nodes, leaves, .. } = costs.counts;
        // The model of the traversal unit does not count the leaves that it reads.
        let leaves = if leaves == 0 && triangle > 0 { "-".to_string() } else { leaves.to_string() };
        writeln!(
            out,
            "{name:<14} {:>10} {:>10} {quadbox:>11} {triangle:>11} {behind:>11} {nodes:>11} {leaves:>10}",
            costs.rays, costs.hits
        )?;
    }
    let (rays, jobs) =
        kinds.iter().fold((0, 0), |(rays, jobs), (_, costs)| (rays + costs.rays, jobs + costs.counts.jobs()));
    writeln!(
        out,
        "{seconds:.2} s by the functional model: {:.2e} rays/s, {:.2e} jobs/s, {:.1} jobs a ray\n",
        rays as f64 / seconds,
        jobs as f64 / seconds,
        jobs as f64 / rays.max(1) as f64
    )?;
    Ok(())
}
