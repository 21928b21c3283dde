//! Faults in the modules of the unit, and whether checks of modules and the first episodes of the campaign find them.

use super::proofs::Obligation;
use super::setting::Setting;
use super::{campaign, modules};
use crate::Error;
use crate::control::{CheckResult, ModelChecker};
use crate::equivalence::Equivalence;
use crate::sat::Prover;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use raypath_hdl::mutate::{Fault, faults, replace};
use raypath_hdl::{Module, verilog};
use raypath_rtl::Config;
use raypath_unit::{NetlistEngine, StepParameters, UnitNetlist, UnitParameters};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// A module of the unit, and the faults that it can have.
pub struct Subject {
    unit: Arc<UnitNetlist>,
    module: Arc<Module>,
    /// All its faults.
    pub faults: Vec<Fault>,
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

/// The modules of the unit besides the datapath and the floating-point units, which `mutation` has.
///
/// # Errors
/// The unit cannot be built.
pub fn subjects() -> Result<Vec<Subject>, Error> {
    let step = StepParameters { stack: 2, ..StepParameters::default() };
    let parameters = UnitParameters { contexts: 8, step, memory_width: 256, divider_latency: 2, id_width: 16 };
    let unit = Arc::new(UnitNetlist::new(Config::DEFAULT, parameters)?);
    let modules = verilog::modules(&unit.top)?;
    let own = modules.into_iter().filter(|module| module.name().starts_with("raypath_unit"));
    let subject = |module: Arc<Module>| Subject { unit: unit.clone(), faults: faults(&module), module };
    Ok(own.map(subject).filter(|subject| !subject.faults.is_empty()).collect())
}

/// The cycles of the first episodes without a fault, four times: a unit that takes more has a fault.
///
/// # Errors
/// The netlist cannot be compiled.
pub fn limits(subjects: &[Subject], seed: u64) -> Result<Vec<u64>, Error> {
    let Some(Subject { unit, .. }) = subjects.first() else { return Ok(Vec::new()) };
    let mut netlist = NetlistEngine::new(unit)?;
    let mut cycles = |number| campaign::run(&mut netlist, unit, [seed, number], None);
    Ok((0..EPISODES).map_while(|number| Some(4 * cycles(number).ok()?.cycles)).collect())
}

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
    pub fn fate(&self, seed: u64, limits: &[u64], stop: &AtomicBool) -> Result<Fate, Error> {
        let faulty = Arc::new(self.fault.apply(&self.subject.module)?);
        match self.simulated(&faulty, seed, limits)? {
            Some(fate) => Ok(fate),
            None => self.proved(&faulty, stop),
        }
    }

    /// What simulation finds.
    fn simulated(&self, faulty: &Arc<Module>, seed: u64, limits: &[u64]) -> Result<Option<Fate>, Error> {
        let unit = &self.subject.unit;
        if modules::check(faulty, unit.parameters, seed)?.is_err() {
            return Ok(Some(Fate::Checked));
        }
        let mut netlist = NetlistEngine::of_module(&replace(&unit.top, faulty)?)?;
        for (number, &limit) in (0..).zip(limits) {
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
            && let Some([refutation, proof]) = Setting::least(false)?.faulty(faulty)?
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
