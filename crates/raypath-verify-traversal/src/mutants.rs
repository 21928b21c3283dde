//! Faults in the modules of the unit, and whether checks of modules and the first episodes of the campaign find them.

use super::claims::properties_suffice;
use super::proofs::Obligation;
use super::setting::{Setting, Variant};
use super::{campaign, modules};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use raypath_hdl::Error::Loop;
use raypath_hdl::mutate::{Fault, faults, replace};
use raypath_hdl::{Module, verilog};
use raypath_traversal::{NetlistEngine, UnitNetlist, UnitParameters};
use raypath_verify::Error;
use raypath_verify::equivalence::Equivalence;
use raypath_verify::safety::{CheckResult, ModelChecker};
use raypath_verify::sat::Prover;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// A module of the unit, and the faults that it can have.
pub struct MutatedModule {
    variant: Variant,
    unit: Arc<UnitNetlist>,
    module: Arc<Module>,
    /// All its faults.
    pub faults: Vec<Fault>,
}

impl MutatedModule {
    /// The module without a fault, and the parameters of its unit.
    pub fn original(self) -> (Arc<Module>, UnitParameters) {
        (self.module, self.unit.parameters)
    }
}

/// A fault in a module.
pub struct Mutant<'s> {
    subject: &'s MutatedModule,
    fault: &'s Fault,
}

/// What became of a fault.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fate {
    /// The check of the module by itself failed.
    Checked,
    /// An episode failed.
    Killed,
    /// Neither failed, and the model checker refutes the properties of the module.
    Refuted,
    /// None of these, and the modules are proven equivalent, with registers and memories as cut points.
    Equivalent,
    /// None of these, and the properties of the module, which are all that it must do, are proved in spite of it.
    Harmless,
    /// None of these, and the proof had this result.
    Survived(String),
}

/// The time limit of an equivalence check.
const LIMIT: Duration = Duration::from_secs(20);
/// Episodes that run on each mutant, the short ones first.
const EPISODES: u64 = 64;

/// The modules of the least units besides the datapath and the floating-point units, which `mutation` has. A module
/// that has the same text in several units is one subject, as is one of rays in a unit of searches.
///
/// # Errors
/// A unit cannot be built.
pub fn modules() -> Result<Vec<MutatedModule>, Error> {
    let mut subjects = Vec::new();
    let mut texts: HashSet<String> = HashSet::new();
    for variant in Variant::ALL {
        let unit = Arc::new(Setting::least(variant)?.unit);
        for module in verilog::modules(&unit.top)? {
            let text = verilog::print_module(&module, &[])?;
            let faults = if module.name().starts_with("raypath_unit") || module.name().starts_with("raypath_search") {
                faults(&module)
            } else {
                Vec::new()
            };
            // A unit of searches has a memory of its own width, and otherwise the modules of rays that others have.
            let is_known = variant == Variant::Searches
                && module.name() != unit.top.name()
                && subjects.iter().any(|other: &MutatedModule| other.module.name() == module.name());
            if !faults.is_empty() && !is_known && texts.insert(text) {
                subjects.push(MutatedModule { variant, unit: unit.clone(), module, faults });
            }
        }
    }
    Ok(subjects)
}

/// A random sample of about `count` faults: the same number of each module, as far as it has so many.
pub fn choose(subjects: &[MutatedModule], count: usize, seed: u64) -> Vec<Mutant<'_>> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let share = count.div_ceil(subjects.len().max(1));
    let mut mutants = Vec::new();
    for subject in subjects {
        let mut faults: Vec<&Fault> = subject.faults.iter().collect();
        faults.shuffle(&mut random);
        mutants.extend(faults.into_iter().take(share).map(|fault| Mutant { subject, fault }));
    }
    mutants.shuffle(&mut random);
    mutants.truncate(count);
    mutants
}

impl Mutant<'_> {
    /// The fault, and the kind of unit that has it.
    pub fn description(&self) -> String {
        format!("{}, {:?}", self.fault, self.subject.variant)
    }

    /// Runs the check of the module by itself, the first episodes of the campaign, and then the proofs.
    ///
    /// # Errors
    /// The faulty netlist cannot be built, or a program is missing.
    pub fn fate(&self, seed: u64, stop: &AtomicBool) -> Result<Fate, Error> {
        let faulty = Arc::new(self.fault.apply(&self.subject.module)?);
        match self.simulated(&faulty, seed) {
            // No simulator accepts a combinational loop.
            Err(Error::Netlist(Loop(_))) => Ok(Fate::Checked),
            Err(other) => Err(other),
            Ok(Some(fate)) => Ok(fate),
            Ok(None) => self.proved(&faulty, stop),
        }
    }

    /// What simulation finds.
    fn simulated(&self, faulty: &Arc<Module>, seed: u64) -> Result<Option<Fate>, Error> {
        let unit = &self.subject.unit;
        if modules::check(faulty, unit.parameters, seed)?.is_err() {
            return Ok(Some(Fate::Checked));
        }
        let mut netlist = NetlistEngine::of_module(&replace(&unit.top, faulty)?)?;
        for number in 0..EPISODES {
            if campaign::run(&mut netlist, unit, [seed, number], true).is_err() {
                return Ok(Some(Fate::Killed));
            }
        }
        Ok(None)
    }

    /// What proofs find.
    fn proved(&self, faulty: &Arc<Module>, stop: &AtomicBool) -> Result<Fate, Error> {
        let module = &self.subject.module;
        let mut found = Prover::find()?.equivalent(&[(module, faulty)], LIMIT, stop);
        if !matches!(found.as_deref(), Ok([Equivalence::Proved]))
            && let Some([refutation, proof]) = Setting::least(self.subject.variant)?.faulty(faulty)?
        {
            let checker = ModelChecker::find()?;
            // An error is that of an assertion without state, to which synthesis may reduce a faulty module.
            let check = |obligation: &Obligation| checker.check(&obligation.problem, stop).ok().flatten();
            if check(&refutation) == Some(CheckResult::Fails) {
                return Ok(Fate::Refuted);
            }
            if properties_suffice(module) && check(&proof) == Some(CheckResult::Holds) {
                return Ok(Fate::Harmless);
            }
        }
        Ok(match found.as_mut().map(Vec::pop) {
            Ok(Some(Equivalence::Proved)) => Fate::Equivalent,
            Ok(Some(Equivalence::Different(_))) => Fate::Survived("different as modules".to_string()),
            Ok(Some(Equivalence::Undecided(why))) => Fate::Survived(format!("undecided as modules: {why}")),
            Ok(None) => Fate::Survived("no result".to_string()),
            Err(problem) => Fate::Survived(format!("not compared as modules: {problem}")),
        })
    }
}
