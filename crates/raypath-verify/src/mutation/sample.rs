//! Which modules get faults, and which of their faults are tried.

use super::Mutant;
use super::units::Unit;
use crate::error::Error;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use raypath_hdl::mutate::{Fault, faults};
use raypath_hdl::{Module, verilog};
use raypath_model::Shape;
use raypath_rtl::{Config, Datapath};
use raypath_sim::engine::shape;
use std::collections::HashSet;
use std::sync::Arc;

/// A module of a datapath, with its faults.
pub struct Subject {
    pub datapath: Arc<Elaborated>,
    pub module: Arc<Module>,
    /// What it is a part of, if it is arithmetic.
    pub unit: Option<Unit>,
    pub faults: Vec<Fault>,
}

/// A configuration's netlist, and how it should behave.
pub struct Elaborated {
    pub config: Config,
    pub top: Arc<Module>,
    pub shape: Shape,
}

/// All modules of these configurations that have faults, those that are alike once.
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

/// About `count` faults: a few of every module, the rest by the number of faults that it has. With fewer than modules,
/// one of each of so many.
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
