//! Faults in the modules of the unit, and whether checks of modules and the first episodes of the campaign find them.

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
pub struct Subject {
    variant: Variant,
    unit: Arc<UnitNetlist>,
    module: Arc<Module>,
    /// All its faults.
    pub faults: Vec<Fault>,
}

impl Subject {
    /// The module without a fault, and the parameters of its unit.
    pub fn original(self) -> (Arc<Module>, UnitParameters) {
        (self.module, self.unit.parameters)
    }
}

/// A fault in a module.
pub struct Mutant<'s> {
    subject: &'s Subject,
    /// The fault.
    pub fault: &'s Fault,
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
    /// None of these, and the properties of the module, which are all that a queue must do, are proved in spite of it.
    Harmless,
    /// None of these, and the proof had this result.
    Survived(String),
}

/// The time limit of an equivalence check.
const LIMIT: Duration = Duration::from_secs(20);
/// Episodes that run on each mutant, the short ones first.
const EPISODES: u64 = 24;

/// The modules of the least units besides the datapath and the floating-point units, which `mutation` has. A module
/// that has the same text in several units is one subject.
///
/// # Errors
/// A unit cannot be built.
pub fn subjects() -> Result<Vec<Subject>, Error> {
    let mut subjects = Vec::new();
    let mut texts: HashSet<String> = HashSet::new();
    for variant in Variant::ALL {
        let unit = Arc::new(Setting::least(variant, false)?.unit);
        for module in verilog::modules(&unit.top)? {
            let text = verilog::print_module(&module, &[])?;
            let faults = if module.name().starts_with("raypath_unit") { faults(&module) } else { Vec::new() };
            if !faults.is_empty() && texts.insert(text) {
                subjects.push(Subject { variant, unit: unit.clone(), module, faults });
            }
        }
    }
    Ok(subjects)
}

/// The cycles of the first episodes without a fault, four times, for each variant: a unit that takes more has a fault.
///
/// # Errors
/// A netlist cannot be compiled.
pub fn limits(seed: u64) -> Result<Limits, Error> {
    let mut limits = Limits::default();
    for (variant, limits) in Variant::ALL.into_iter().zip(&mut limits) {
        let unit = Setting::least(variant, false)?.unit;
        let mut netlist = NetlistEngine::new(&unit)?;
        let mut cycles = |number| campaign::run(&mut netlist, &unit, [seed, number], None);
        *limits = (0..EPISODES).map_while(|number| Some(4 * cycles(number).ok()?.cycles)).collect();
    }
    Ok(limits)
}

/// The most cycles of the first episodes, for each variant in the order of [`Variant::ALL`].
pub type Limits = [Vec<u64>; 3];

/// A random sample of about `count` faults: the same number of each module, as far as it has so many.
pub fn choose(subjects: &[Subject], count: usize, seed: u64) -> Vec<Mutant<'_>> {
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
    /// Runs the check of the module by itself, the first episodes of the campaign, and then the proofs.
    ///
    /// # Errors
    /// The faulty netlist cannot be built, or a program is missing.
    pub fn fate(&self, seed: u64, limits: &Limits, stop: &AtomicBool) -> Result<Fate, Error> {
        let faulty = Arc::new(self.fault.apply(&self.subject.module)?);
        match self.simulated(&faulty, seed, limits) {
            // No simulator accepts a combinational loop.
            Err(Error::Netlist(Loop(_))) => Ok(Fate::Checked),
            Err(other) => Err(other),
            Ok(Some(fate)) => Ok(fate),
            Ok(None) => self.proved(&faulty, stop),
        }
    }

    /// What simulation finds.
    fn simulated(&self, faulty: &Arc<Module>, seed: u64, limits: &Limits) -> Result<Option<Fate>, Error> {
        let unit = &self.subject.unit;
        if modules::check(faulty, unit.parameters, seed)?.is_err() {
            return Ok(Some(Fate::Checked));
        }
        let mut netlist = NetlistEngine::of_module(&replace(&unit.top, faulty)?)?;
        for (number, &limit) in (0..).zip(&limits[self.subject.variant as usize]) {
            if campaign::run(&mut netlist, unit, [seed, number], Some(limit)).is_err() {
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
            && let Some([refutation, proof]) = Setting::least(self.subject.variant, false)?.faulty(faulty)?
        {
            let checker = ModelChecker::find()?;
            // An error is that of an assertion without state, to which synthesis may reduce a faulty module.
            let check = |obligation: &Obligation| checker.check(&obligation.problem, stop).ok().flatten();
            if check(&refutation) == Some(CheckResult::Fails) {
                return Ok(Fate::Refuted);
            }
            if modules::is_queue(module) && check(&proof) == Some(CheckResult::Holds) {
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
