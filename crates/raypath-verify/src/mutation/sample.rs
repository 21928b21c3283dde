//! The modules that get faults, and the sample of their faults.

use super::mutant::{Elaborated, Mutant, Subject};
use super::units::Unit;
use crate::error::Error;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use raypath_hdl::mutate::{Fault, faults};
use raypath_hdl::verilog;
use raypath_rtl::{Config, Datapath};
use raypath_sim::engine::shape;
use std::collections::HashSet;
use std::sync::Arc;

/// All modules of these configurations that can have faults, equal ones once.
pub fn subjects(configs: &[Config]) -> Result<Vec<Subject>, Error> {
    let mut known = HashSet::new();
    let mut subjects = Vec::new();
    for &config in configs {
        let datapath = Datapath::new(config)?;
        let top = datapath.top().clone();
        let datapath = Arc::new(Elaborated { config, shape: shape(config, &datapath), top });
        for module in verilog::modules(&datapath.top)? {
            let faults = faults(&module);
            if !faults.is_empty() && known.insert(verilog::print_module(&module, &[])?) {
                let unit = Unit::of(config, module.name())?;
                subjects.push(Subject { datapath: datapath.clone(), module, unit, faults });
            }
        }
    }
    Ok(subjects)
}

/// A random sample of about `count` faults: a few of every module, and the rest in proportion to the modules' faults.
/// If there are more modules than `count`, one fault each of `count` modules.
pub fn choose(subjects: &[Subject], count: usize, seed: u64) -> Vec<Mutant<'_>> {
    const A_FEW: usize = 5;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let few = A_FEW.min(count / subjects.len().max(1)).max(1);
    let all: usize = subjects.iter().map(|subject| subject.faults.len()).sum();
    let rest = count.saturating_sub(few * subjects.len());
    let mut mutants = Vec::new();
    for subject in subjects {
        let share = few + (rest * subject.faults.len()).div_ceil(all.max(1));
        let mut faults: Vec<&Fault> = subject.faults.iter().collect();
        faults.shuffle(&mut rng);
        mutants.extend(faults.into_iter().take(share).map(|fault| Mutant { subject, fault }));
    }
    mutants.shuffle(&mut rng);
    if count < subjects.len() {
        mutants.truncate(count);
    }
    mutants
}
