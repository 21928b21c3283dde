//! The checks of the regression tests on a mutant, and the proofs about one that passes them.
//!
//! Two proofs show that a fault changes nothing. The module with the fault is equivalent to the one without, register
//! by register, by SAT. Or, because many values of a stage are don't-cares that only the stages behind show: the
//! datapath with the fault computes each operation for a job by itself, as the item `operations` proves it, its control
//! is the same, and all data loads with the opcode, so that a job that waits leaves what a job does that does not wait.

use super::mutant::{Elaborated, FaultyModule};
use crate::report::Fate;
use raypath_float::{Format, encode};
use raypath_hdl::text::plain;
use raypath_hdl::{Builder, Module, Port, SignalId, Wire};
use raypath_sim::engine::NetlistEngine;
use raypath_sim::lockstep::{FailedCheck, RegressionChecks};
use raypath_verify::Error;
use raypath_verify::equivalence::Equivalence;
use raypath_verify::sat::Prover;
use raypath_verify_datapath::control::together;
use raypath_verify_datapath::dataflow::still_computes;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::time::Duration;

/// The time limit of an equivalence check, for Yosys and ABC each, and of a question to Z3.
const LIMIT: Duration = Duration::from_secs(20);

pub struct Trial<'s> {
    pub subject: &'s FaultyModule,
    /// The module with the fault.
    pub module: Arc<Module>,
    /// The datapath with that module.
    pub top: Arc<Module>,
}

impl Trial<'_> {
    /// Runs the checks, the cheapest first, until one fails; then the proofs.
    pub fn run(&self) -> Result<Fate, Error> {
        if let Some(unit) = &self.subject.unit
            && let Some(check) = unit.check(&self.module)?
        {
            return Ok(Fate::Killed(check.to_string()));
        }
        // In folded pipelines data and opcode load in different rounds.
        let is_clean = |module: &Arc<Module>| together(module).is_empty();
        if self.subject.datapath.shape.interval == 1 && is_clean(&self.subject.module) && !is_clean(&self.module) {
            return Ok(Fate::Killed("structure".to_string()));
        }
        match self.check_datapath()? {
            Err(failed) => Ok(Fate::Killed(failed.check.to_string())),
            Ok(()) => self.proof(),
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

    /// The result of a mutant that passes all checks.
    pub fn proof(&self) -> Result<Fate, Error> {
        if self.computes_the_operations()? {
            return Ok(Fate::Equivalent("as operations".to_string()));
        }
        // A proof of the top module would take minutes.
        if self.subject.module.name() == self.subject.datapath.top.name() {
            return Ok(Fate::Survived("not proven".to_string()));
        }
        let Elaborated { config, ref shape, .. } = *self.subject.datapath;
        let [original, changed] = [&self.subject.module, &self.module].map(|module| match shape.interval {
            2.. if has_data(module) => on_rounds(module, shape.interval),
            _ => on_numbers(module, config.semantics.format),
        });
        match compared(&original?, &changed?) {
            Ok(Equivalence::Proved) => Ok(Fate::Equivalent("as modules".to_string())),
            Ok(Equivalence::Different(_)) => Ok(Fate::Survived("different as modules".to_string())),
            Ok(Equivalence::Undecided(why)) => Ok(Fate::Survived(format!("undecided as modules: {why}"))),
            Err(Error::Tool(problem)) => Ok(Fate::Survived(format!("not compared as modules: {problem}"))),
            Err(other) => Err(other),
        }
    }

    /// Whether the fault is in the data of a pipeline without rounds, and its operations are still computed.
    pub fn computes_the_operations(&self) -> Result<bool, Error> {
        let Elaborated { config, ref shape, ref top } = *self.subject.datapath;
        let is_data = shape.interval == 1
            && top.memory_bits() == 0
            && together(&self.module).is_empty()
            && has_data(&self.subject.module)
            && has_same_control(&self.subject.module, &self.module);
        Ok(is_data && still_computes(config, &plain(&self.top), LIMIT)?)
    }
}

/// Whether a module is neither a unit nor control.
fn has_data(module: &Module) -> bool {
    let is_control = ["raypath_skid", "raypath_exit", "raypath_credit", "raypath_rounds"].contains(&module.name());
    !is_control && !module.name().starts_with("raypath_fp_")
}

/// Whether enables, registers with a reset, handshakes and the inputs of control are what they were: computed from the
/// same inputs, registers and instances in the same way.
fn has_same_control(original: &Module, changed: &Module) -> bool {
    let registers = |module: &Module| -> Vec<(bool, Option<u64>)> {
        module.registers().iter().map(|register| (register.enable.is_some(), register.reset)).collect()
    };
    // A fault can insert signals, so that the others have other numbers.
    let input = |module: &Module, id: SignalId| module.inputs().iter().position(|port| port.signal == id);
    let (mut open, mut other) = (control(original), control(changed));
    if registers(original) != registers(changed) || open.len() != other.len() {
        return false;
    }
    let mut known = BTreeSet::new();
    while let (Some(a), Some(b)) = (open.pop(), other.pop()) {
        let [was, is] = [&original.signal(a).driver, &changed.signal(b).driver];
        if !was.has_operator_of(is) || input(original, a) != input(changed, b) {
            return false;
        }
        if known.insert([a, b]) {
            open.extend(was.operands());
            other.extend(is.operands());
        }
    }
    true
}

/// The signals that control consists of.
fn control(module: &Module) -> Vec<SignalId> {
    let is_handshake = |port: &&Port| {
        let has_written = port.stem().ends_with("_written");
        has_written || ["valid", "ready", "opcode", "returned"].contains(&port.stem())
    };
    let mut signals: Vec<SignalId> = module.outputs().iter().filter(is_handshake).map(|port| port.signal).collect();
    for register in module.registers() {
        signals.extend(register.enable);
        signals.extend(register.reset.map(|_| register.next));
    }
    for instance in module.instances() {
        let ports = instance.module.inputs().iter().zip(&instance.inputs);
        let is_control = !has_data(&instance.module) && !instance.module.name().starts_with("raypath_fp_");
        signals.extend(ports.filter(|(port, _)| is_control || is_handshake(port)).map(|(_, signal)| *signal));
    }
    signals
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

/// A module of a folded pipeline whose control says what it can say: jobs are at positions at least an interval apart,
/// and move only from where they are.
fn on_rounds(module: &Arc<Module>, interval: usize) -> Result<Arc<Module>, Error> {
    let m = Builder::new(&format!("{}_on_rounds", module.name()));
    let position = |port: &Port, stem: &str| port.stem().strip_prefix(stem)?.parse::<usize>().ok();
    let last =
        module.inputs().iter().filter_map(|port| position(port, "at_").or_else(|| position(port, "moves_"))).max();
    let mut at: Vec<Wire<'_>> = Vec::new();
    for place in 0..last.map_or(0, |last| last + 1) {
        let any = m.input(&format!("any_{place}"), 1);
        let near = at[(place + 1).saturating_sub(interval)..].iter();
        let is_at = near.fold(any, |is_at, &other| is_at & !other);
        at.push(is_at);
    }
    let mut inputs = Vec::new();
    for port in module.inputs() {
        let any = || m.input(&format!("any_{}", port.name), module.signal(port.signal).width);
        let value = match (position(port, "at_"), position(port, "moves_")) {
            (Some(place), _) => at[place],
            (None, Some(place)) => at[place] & any(),
            (None, None) => any(),
        };
        inputs.push((port.name.as_str(), value));
    }
    for (port, result) in module.outputs().iter().zip(m.instance("u_module", module, &inputs)) {
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
