//! Random jobs of any datapath, by the specifications of its operations.

use crate::AnyOperationSpec;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_sim::jobs::{any_job, random};
use raypath_sim::{Datapath, OperationId, Words};

/// An endless stream of jobs for any datapath: the paper's operations as [`random`](fn@random) has them, those of
/// `specs` as they say themselves, and of ports that are neither's any value. `kinds` must not be empty.
pub fn jobs(
    datapath: &Datapath,
    specs: &[AnyOperationSpec],
    seed: u64,
    kinds: &[OperationId],
) -> impl Iterator<Item = Words> + use<> {
    let (model, config) = (datapath.model(), datapath.config());
    let mut sources: Vec<(OperationId, Source)> = Vec::new();
    for (&kind, seed) in kinds.iter().zip(seed..) {
        let paper = config.kinds().iter().find(|paper| paper.name() == kind.name());
        let spec = specs.iter().find(|spec| spec.name() == kind.name());
        sources.push((
            kind,
            match (paper, spec) {
                (_, Some(spec)) => Source::Spec(spec.clone()),
                (Some(&paper), None) => {
                    Source::Paper(Box::new(random(&model, config.semantics.format, seed, &[paper])))
                }
                (None, None) => Source::Any,
            },
        ));
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    std::iter::repeat_with(move || {
        let chosen = rng.random_range(0..sources.len());
        let (kind, source) = &mut sources[chosen];
        match source {
            Source::Spec(spec) => spec.job(&model, *kind, &mut rng),
            Source::Any => any_job(&model, *kind, &mut rng),
            Source::Paper(jobs) => jobs.next().unwrap_or_else(|| any_job(&model, *kind, &mut rng)),
        }
    })
}

/// Where the jobs of an operation come from.
enum Source {
    Spec(AnyOperationSpec),
    Paper(Box<dyn Iterator<Item = Words>>),
    Any,
}
