//! Random jobs of any datapath, by the specifications of its operations.

use crate::AnyOperationSpec;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_sim::jobs::{any_job, random};
use raypath_sim::{Datapath, OperationId, Words};

/// An endless stream of jobs of the operations `kinds` of a datapath, reproducible by `seed`. Jobs of an operation in
/// `specs` come from its specification, jobs of the paper's operations from [`random`](fn@random), and others from
/// [`any_job`]. `kinds` must not be empty.
pub fn jobs(
    datapath: &Datapath,
    specs: &[AnyOperationSpec],
    seed: u64,
    kinds: &[OperationId],
) -> impl Iterator<Item = Words> + use<> {
    let (model, config) = (datapath.model(), datapath.config());
    let source = |(&kind, seed): (&OperationId, u64)| -> Source {
        let model = model.clone();
        let paper = config.kinds().iter().find(|paper| kind == **paper);
        if let Some(spec) = specs.iter().find(|spec| spec.name() == kind.name()).cloned() {
            Box::new(move |rng| spec.job(&model, kind, rng))
        } else if let Some(&paper) = paper {
            let mut jobs = random(&model, config.semantics.format, seed, &[paper]);
            Box::new(move |rng| jobs.next().unwrap_or_else(|| any_job(&model, kind, rng)))
        } else {
            Box::new(move |rng| any_job(&model, kind, rng))
        }
    };
    let mut sources: Vec<Source> = kinds.iter().zip(seed..).map(source).collect();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    std::iter::repeat_with(move || {
        let chosen = rng.random_range(0..sources.len());
        sources[chosen](&mut rng)
    })
}

type Source = Box<dyn FnMut(&mut ChaCha8Rng) -> Words>;
