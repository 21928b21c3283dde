//! One mutant before the checks of the everyday tests.

use super::Fate;
use super::passes::passes_alike;
use super::sample::{Elaborated, Subject};
use crate::equivalence::Equivalence;
use crate::error::Error;
use crate::sat::Prover;
use raypath_hdl::Module;
use raypath_sim::engine::NetlistEngine;
use raypath_sim::lockstep::{Everyday, Failed};
use raypath_sim::models::{PaperModel, Visitor, with_model};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::time::Duration;

/// What a comparison of two modules may take, Yosys and ABC each.
const LIMIT: Duration = Duration::from_secs(20);

/// A mutant.
pub struct Trial<'s> {
    pub subject: &'s Subject,
    /// The module with the fault.
    pub module: Arc<Module>,
    /// The datapath with that module.
    pub top: Arc<Module>,
}

impl Trial<'_> {
    /// The cheapest check first, until one fails; then proofs. Stages are compared as modules only where `proves_modules`
    /// holds, because that takes many seconds.
    pub fn run(&self, proves_modules: bool) -> Result<Fate, Error> {
        if let Some(unit) = &self.subject.unit
            && let Some(check) = unit.check(&self.module)?
        {
            return Ok(Fate::Killed(check));
        }
        let Elaborated { config, .. } = *self.subject.datapath;
        match with_model(config, Whole { datapath: &self.subject.datapath, top: &self.top })? {
            Err(failed) => Ok(Fate::Killed(failed.check)),
            Ok(()) => self.proof(proves_modules),
        }
    }

    /// What a survivor is.
    fn proof(&self, proves_modules: bool) -> Result<Fate, Error> {
        let original = &self.subject.module;
        if passes_alike(self) {
            return Ok(Fate::Equivalent("alike to every job"));
        }
        let is_small = self.subject.unit.is_some() || original.instances().is_empty();
        if !is_small && !proves_modules {
            return Ok(survived("not alike to every job"));
        }
        // The top's modules are compared where the top is not the module: its proof would take minutes.
        if original.name() == self.subject.datapath.top.name() {
            return Ok(survived("not alike to every job"));
        }
        match compared(original, &self.module) {
            Ok(Equivalence::Proved) => Ok(Fate::Equivalent("alike as modules")),
            Ok(Equivalence::Different(_)) => Ok(survived("different as modules")),
            Ok(Equivalence::Undecided(why)) => Ok(survived(&format!("undecided as modules: {why}"))),
            Err(problem @ (Error::Program { .. } | Error::Tool(_))) => {
                Ok(survived(&format!("not compared as modules: {problem}")))
            }
            Err(other) => Err(other),
        }
    }
}

fn survived(what: &str) -> Fate {
    Fate::Survived(what.to_string())
}

/// Compares two modules, within [`LIMIT`].
fn compared(original: &Arc<Module>, changed: &Arc<Module>) -> Result<Equivalence, Error> {
    let prover = Prover::find()?;
    let stop = AtomicBool::new(false);
    let (done, is_done) = mpsc::channel::<()>();
    std::thread::scope(|scope| {
        let stop = &stop;
        scope.spawn(move || {
            // It is over when nobody holds `done` any more.
            if is_done.recv_timeout(2 * LIMIT) == Err(mpsc::RecvTimeoutError::Timeout) {
                stop.store(true, Ordering::Relaxed);
            }
        });
        let found = prover.equivalent(&[(original, changed)], LIMIT, stop);
        drop(done);
        Ok(found?.remove(0))
    })
}

/// The checks of a whole datapath.
struct Whole<'t> {
    datapath: &'t Elaborated,
    top: &'t Arc<Module>,
}

impl Visitor for Whole<'_> {
    type Answer = Result<Result<(), Failed>, Error>;

    fn visit<M: PaperModel>(self, model: M) -> Self::Answer {
        let Elaborated { config, shape, .. } = self.datapath;
        let mut netlist =
            NetlistEngine::of_module(model.clone(), *config, self.top, shape.clone(), Everyday::observes)?;
        Ok(Everyday { config: *config, seed: 1, jobs: Everyday::THOROUGH }.check(&mut netlist, &model))
    }
}
