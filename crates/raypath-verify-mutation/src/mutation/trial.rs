//! The checks of the regression tests on a mutant.

use super::mutant::{Elaborated, MutantResult, Subject};
use super::symbolic::{Effect, effect};
use raypath_float::{Format, encode};
use raypath_hdl::mutate::without_text;
use raypath_hdl::{Builder, Module, Port};
use raypath_sim::engine::NetlistEngine;
use raypath_sim::lockstep::{FailedCheck, RegressionChecks};
use raypath_verify::Error;
use raypath_verify::equivalence::Equivalence;
use raypath_verify::sat::Prover;
use raypath_verify_datapath::control::together;
use raypath_verify_datapath::dataflow::still_computes;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::time::Duration;

/// The time limit of an equivalence check, for Yosys and ABC each, and of a question to Z3.
const LIMIT: Duration = Duration::from_secs(20);

pub struct Trial<'s> {
    pub subject: &'s Subject,
    /// The module with the fault.
    pub module: Arc<Module>,
    /// The datapath with that module.
    pub top: Arc<Module>,
}

impl Trial<'_> {
    /// Runs the checks, the cheapest first, until one fails; then the proofs. Stages are compared as modules only if
    /// `proves_modules` holds, because that takes many seconds.
    pub fn run(&self, proves_modules: bool) -> Result<MutantResult, Error> {
        if let Some(unit) = &self.subject.unit
            && let Some(check) = unit.check(&self.module)?
        {
            return Ok(MutantResult::Killed(check.into()));
        }
        // In folded pipelines data and opcode load in different rounds.
        let is_clean = |module: &Arc<Module>| together(module).is_empty();
        if self.subject.datapath.shape.interval == 1 && is_clean(&self.subject.module) && !is_clean(&self.module) {
            return Ok(MutantResult::Killed("structure".into()));
        }
        match self.check_datapath()? {
            Err(failed) => Ok(MutantResult::Killed(failed.check.into())),
            Ok(()) => self.proof(proves_modules),
        }
    }

    fn check_datapath(&self) -> Result<Result<(), FailedCheck>, Error> {
        let Elaborated { config, ref shape, .. } = *self.subject.datapath;
        let model = raypath_sim::Datapath::paper(config).model();
        let netlist =
            NetlistEngine::of_module(model.clone(), config, &self.top, shape.clone(), RegressionChecks::observes);
        let mut netlist = match netlist {
            Err(raypath_rtl::Error::Netlist(raypath_hdl::Error::Loop(signals))) => {
                let what = signals.join(" -> ");
                return Ok(Err(FailedCheck { check: "no combinational loop", what }));
            }
            other => other?,
        };
        Ok(RegressionChecks { config, seed: 1, jobs: RegressionChecks::THOROUGH }.check(&mut netlist, &model))
    }

    /// Whether each operation's job by itself has the outcome that it must have, and all jobs pass alike: the registers
    /// of a step load together, so that a job that waits in it leaves what a job that does not wait leaves. In folded
    /// pipelines a register may load at other times too.
    pub fn still_computes(&self) -> Result<bool, Error> {
        let Elaborated { config, ref shape, .. } = *self.subject.datapath;
        let passes_alike = shape.interval == 1 && together(&self.module).is_empty();
        Ok(passes_alike && still_computes(config, &without_text(&self.top), LIMIT)?)
    }

    /// The result of a mutant that passes all checks.
    fn proof(&self, proves_modules: bool) -> Result<MutantResult, Error> {
        let original = &self.subject.module;
        match effect(self.subject, &self.module, &self.top)? {
            Effect::None => return Ok(MutantResult::Equivalent("for every job".into())),
            Effect::Data if self.still_computes()? => return Ok(MutantResult::Equivalent("as operations".into())),
            Effect::Data | Effect::Any => {}
        }
        let is_small = self.subject.unit.is_some() || original.instances().is_empty();
        if !is_small && !proves_modules {
            return Ok(survived("not proven for every job"));
        }
        // A proof of the top module would take minutes.
        if original.name() == self.subject.datapath.top.name() {
            return Ok(survived("not proven for every job"));
        }
        let format = self.subject.datapath.config.semantics.format;
        let [original, changed] = [&self.subject.module, &self.module].map(|module| on_numbers(module, format));
        match compared(&original?, &changed?) {
            Ok(Equivalence::Proved) => Ok(MutantResult::Equivalent("as modules".into())),
            Ok(Equivalence::Different(_)) => Ok(survived("different as modules")),
            Ok(Equivalence::Undecided(why)) => Ok(survived(&format!("undecided as modules: {why}"))),
            Err(Error::Tool(problem)) => Ok(survived(&format!("not compared as modules: {problem}"))),
            Err(other) => Err(other),
        }
    }
}

fn survived(what: &str) -> MutantResult {
    MutantResult::Survived(what.to_string())
}

/// A floating-point unit with operands that encode any numbers of the format in any way. Other words have no meaning
/// for a unit, and no unit gives them. Any other module, or part of a unit without operands, as it is.
fn on_numbers(unit: &Arc<Module>, format: Format) -> Result<Arc<Module>, Error> {
    let width = format.recoded_width();
    let is_operand = |port: &Port| {
        ["a_i", "b_i", "recoded_i"].contains(&port.name.as_str()) && unit.port_width(&port.name) == Some(width)
    };
    if !unit.name().starts_with("raypath_fp_") || !unit.inputs().iter().all(is_operand) {
        return Ok(unit.clone());
    }
    let encode = encode(format)?;
    let m = Builder::new(&format!("{}_on_numbers", unit.name()));
    let mut operands = Vec::new();
    for port in unit.inputs() {
        let number = m.input(&format!("number_{}", port.name), format.ieee_width());
        let word = m.instance(&format!("u_encode_{}", port.name), &encode, &[("ieee_i", number)])[0];
        // Zeros and infinities ignore the bits below the class; NaNs ignore the sign too.
        let class = word.lower(width - 1).upper(3);
        let [zero, infinite, nan] = [0, 6, 7].map(|value| class.equals(m.constant(3, value)));
        let ignored = (zero | infinite | nan).replicate(width - 4);
        let ignored = m.concat(&[nan, m.constant(3, 0), ignored]);
        operands.push((port.name.as_str(), word ^ (m.input(&format!("any_{}", port.name), width) & ignored)));
    }
    for (port, result) in unit.outputs().iter().zip(m.instance("u_unit", unit, &operands)) {
        m.output(&port.name, result);
    }
    Ok(m.finish()?)
}

/// Compares two modules, within [`LIMIT`].
pub fn compared(original: &Arc<Module>, changed: &Arc<Module>) -> Result<Equivalence, Error> {
    let prover = Prover::find()?;
    let stop = AtomicBool::new(false);
    let (done, is_done) = mpsc::channel::<()>();
    std::thread::scope(|scope| {
        let stop = &stop;
        scope.spawn(move || {
            // The sender is dropped when the check has ended.
            if is_done.recv_timeout(2 * LIMIT) == Err(mpsc::RecvTimeoutError::Timeout) {
                stop.store(true, Ordering::Relaxed);
            }
        });
        let found = prover.equivalent(&[(original, changed)], LIMIT, stop);
        drop(done);
        Ok(found?.remove(0))
    })
}
