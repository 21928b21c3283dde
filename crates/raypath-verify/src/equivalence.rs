//! Equivalence checks: proofs that two modules behave alike, register by register.

use crate::error::Error;
use crate::sat::{Miter, ProofResult, Prover, SOURCE};
use raypath_hdl::{Module, Port, Simulator, expose_registers, verilog};
use raypath_tools::ToolError;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// The result of an equivalence check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Equivalence {
    /// For all values of inputs and registers, the outputs and the registers' next values are equal. Hence the modules
    /// behave alike in every cycle.
    Proved,
    /// For these values of inputs and registers, by name, an output or a next value differs; the simulator has
    /// confirmed it. The combination of register values need not be reachable.
    Different(BTreeMap<String, u64>),
    /// The check has no result, for this reason.
    Undecided(String),
}

impl Prover {
    /// Compares pairs of modules, in at most `limit` each. The modules of a pair have the same ports and, in them and
    /// in their instances, the same registers by name. Yosys starts once for all pairs. When `stop` is set, the
    /// remaining pairs are undecided.
    ///
    /// # Errors
    /// A program is missing or fails; ports or registers differ.
    pub fn equivalent(
        &self,
        pairs: &[(&Arc<Module>, &Arc<Module>)],
        limit: Duration,
        stop: &AtomicBool,
    ) -> Result<Vec<Equivalence>, Error> {
        let exposed: Vec<[Arc<Module>; 2]> =
            pairs.iter().map(|(original, changed)| [expose_registers(original), expose_registers(changed)]).collect();
        let miters: Vec<Miter> = exposed.iter().map(of_exposed).collect::<Result<_, _>>()?;
        let results = self.solve(&miters, limit, stop)?;
        results.into_iter().zip(&exposed).map(|(result, pair)| confirmed(result, pair)).collect()
    }
}

/// Yosys's `proc` without `proc_rmdead`, which removes the default arm of a `case` over all values and leaves an
/// undriven wire.
const TO_LOGIC: &str = "proc_clean; proc_prune; proc_init; proc_arst; proc_rom; proc_mux; proc_dlatch; proc_dff; \
                        proc_memwr; proc_clean; opt_expr -keepdc";

/// The circuit whose output is 1 where the modules differ in an output or in the next value of a register.
///
/// # Errors
/// Ports or registers differ.
pub fn miter(original: &Arc<Module>, changed: &Arc<Module>) -> Result<Miter, Error> {
    of_exposed(&[original, changed].map(expose_registers))
}

fn of_exposed(pair: &[Arc<Module>; 2]) -> Result<Miter, Error> {
    let [original, changed] = pair;
    for (kind, side) in [("inputs", Module::inputs as fn(&Module) -> &[Port]), ("outputs", Module::outputs)] {
        let (expected, found) = (names(original, side(original)), names(changed, side(changed)));
        if expected != found {
            return Err(raypath_hdl::Error::Name {
                module: changed.name().to_string(),
                name: kind.to_string(),
                problem: format!("with the registers' values: found {found:?}, expected {expected:?}"),
            }
            .into());
        }
    }
    let mut commands = Vec::new();
    let mut sources = Vec::new();
    for (side, module) in [("original", original), ("changed", changed)] {
        sources.push((format!("{side}.sv"), verilog::text(module)?));
        let top = module.name();
        commands.extend([format!("read_verilog -sv {SOURCE}{side}.sv"), format!("hierarchy -check -top {top}")]);
        commands.extend([
            TO_LOGIC.to_string(),
            "flatten".to_string(),
            format!("rename {top} {side}"),
            format!("design -stash {side}"),
        ]);
    }
    let copies = ["original", "changed"].map(|side| format!("design -copy-from {side} {side}"));
    commands.extend(copies);
    commands.push("miter -equiv -flatten original changed miter".to_string());
    let inputs = original.inputs().iter().map(|port| (port, original.signal(port.signal).width));
    Ok(Miter {
        name: original.name().to_string(),
        sources,
        commands,
        inputs: inputs.map(|(port, width)| (format!("in_{}", port.name), width)).collect(),
    })
}

/// The ports with their widths.
fn names(module: &Module, ports: &[Port]) -> Vec<(String, u32)> {
    ports.iter().map(|port| (port.name.clone(), module.signal(port.signal).width)).collect()
}

/// The result for modules; the simulator checks a counterexample.
fn confirmed(result: ProofResult, pair: &[Arc<Module>; 2]) -> Result<Equivalence, Error> {
    match result {
        ProofResult::Proved { .. } => Ok(Equivalence::Proved),
        ProofResult::Undecided(why) => Ok(Equivalence::Undecided(why)),
        ProofResult::Stopped => Ok(Equivalence::Undecided("stopped".to_string())),
        ProofResult::Refuted(values) => {
            // Yosys's `miter` puts this prefix before the names of ports.
            let name = |name: String| name.strip_prefix("in_").map(str::to_string).unwrap_or(name);
            let values: BTreeMap<String, u64> = values.into_iter().map(|(port, value)| (name(port), value)).collect();
            if outputs(&pair[0], &values)? == outputs(&pair[1], &values)? {
                let found = format!("{}: not a counterexample: {values:x?}", pair[0].name());
                let expected = "values for which the simulator finds a difference";
                return Err(ToolError::unexpected("abc", found, expected).into());
            }
            Ok(Equivalence::Different(values))
        }
    }
}

/// The values of a module's outputs for these inputs.
fn outputs(module: &Arc<Module>, values: &BTreeMap<String, u64>) -> Result<Vec<u64>, Error> {
    let mut simulator = Simulator::new(module)?;
    let inputs = module.inputs().iter().map(|port| values.get(&port.name).copied().unwrap_or(0));
    Ok(simulator.evaluate(inputs).to_vec())
}
