//! Whether two modules do the same, by proof, with registers taken as given.

use crate::Error;
use crate::proof::{Answer, Problem, Prover, SOURCE};
use raypath_hdl::{Module, Port, Simulator, expose_registers, verilog};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// How two modules stand to each other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Equivalence {
    /// From any values of inputs and registers, all outputs and all next values are equal: they do the same for ever.
    Proved,
    /// For these values of inputs and registers, by name, an output or a next value differs. The simulator has confirmed
    /// it. That these registers can have these values at once is not said.
    Different(BTreeMap<String, u64>),
    /// Nothing is known, for the reason given.
    Undecided(String),
}

/// Compares two modules of the same ports and the same registers, by name, in them and inside their instances; two
/// minutes at most.
///
/// # Errors
/// A program is missing or fails; ports or registers are not the same.
pub fn equivalent(original: &Arc<Module>, changed: &Arc<Module>) -> Result<Equivalence, Error> {
    let never = AtomicBool::new(false);
    let mut found = Prover::find()?.equivalent(&[(original, changed)], Duration::from_secs(120), &never)?;
    Ok(found.remove(0))
}

impl Prover {
    /// Compares pairs of modules like [`equivalent`], `limit` at most for each. Some dozens at a time share the start of
    /// Yosys. Where `stop` is set, the rest is undecided.
    ///
    /// # Errors
    /// Like those of [`equivalent`].
    pub fn equivalent(
        &self,
        pairs: &[(&Arc<Module>, &Arc<Module>)],
        limit: Duration,
        stop: &AtomicBool,
    ) -> Result<Vec<Equivalence>, Error> {
        let exposed: Vec<[Arc<Module>; 2]> =
            pairs.iter().map(|(original, changed)| [expose_registers(original), expose_registers(changed)]).collect();
        let problems: Vec<Problem> = exposed.iter().map(problem).collect::<Result<_, _>>()?;
        let answers = self.solve(&problems, limit, stop)?;
        answers.into_iter().zip(&exposed).map(|(answer, pair)| judge(answer, pair)).collect()
    }
}

/// Yosys's `proc` but for `proc_rmdead`: of a `case` over all values of its selector that would remove the default arm, and
/// leave a wire which nothing drives.
const TO_LOGIC: &[&str] = &[
    "proc_clean",
    "proc_prune",
    "proc_init",
    "proc_arst",
    "proc_rom",
    "proc_mux",
    "proc_dlatch",
    "proc_dff",
    "proc_memwr",
    "proc_clean",
    "opt_expr -keepdc",
];

fn problem(pair: &[Arc<Module>; 2]) -> Result<Problem, Error> {
    let [original, changed] = pair;
    for (kind, side) in [("inputs", Module::inputs as fn(&Module) -> &[Port]), ("outputs", Module::outputs)] {
        let (expected, found) = (described(original, side(original)), described(changed, side(changed)));
        if expected != found {
            return Err(raypath_hdl::Error::Name {
                module: changed.name().to_string(),
                name: kind.to_string(),
                problem: format!("with its registers' values: found {found:?}, expected {expected:?}"),
            }
            .into());
        }
    }
    let mut commands = Vec::new();
    let mut sources = Vec::new();
    for (side, module) in [("original", original), ("changed", changed)] {
        sources.push((format!("{side}.sv"), text(module)?));
        let top = module.name();
        commands.extend([format!("read_verilog -sv {SOURCE}{side}.sv"), format!("hierarchy -check -top {top}")]);
        commands.extend(TO_LOGIC.iter().map(ToString::to_string));
        commands.extend(["flatten".to_string(), format!("rename {top} {side}"), format!("design -stash {side}")]);
    }
    let copies = ["original", "changed"].map(|side| format!("design -copy-from {side} {side}"));
    commands.extend(copies);
    commands.push("miter -equiv -flatten original changed miter".to_string());
    let inputs = original.inputs().iter().map(|port| (port, original.signal(port.signal).width));
    Ok(Problem {
        name: original.name().to_string(),
        sources,
        commands,
        inputs: inputs.map(|(port, width)| (format!("in_{}", port.name), width)).collect(),
    })
}

/// A module and everything below it as SystemVerilog.
pub(crate) fn text(module: &Arc<Module>) -> Result<String, Error> {
    let texts = verilog::modules(module)?.into_iter().map(|module| verilog::print_module(&module, &[]));
    Ok(texts.collect::<Result<Vec<String>, _>>()?.concat())
}

fn described(module: &Module, ports: &[Port]) -> Vec<(String, u32)> {
    ports.iter().map(|port| (port.name.clone(), module.signal(port.signal).width)).collect()
}

fn judge(answer: Answer, pair: &[Arc<Module>; 2]) -> Result<Equivalence, Error> {
    match answer {
        Answer::Proved { .. } => Ok(Equivalence::Proved),
        Answer::Undecided(why) => Ok(Equivalence::Undecided(why)),
        Answer::Stopped => Ok(Equivalence::Undecided("stopped".to_string())),
        Answer::Refuted(values) => {
            // What `miter` puts before the names of ports.
            let name = |name: String| name.strip_prefix("in_").map(str::to_string).unwrap_or(name);
            let values: BTreeMap<String, u64> = values.into_iter().map(|(port, value)| (name(port), value)).collect();
            if shown(&pair[0], &values)? == shown(&pair[1], &values)? {
                return Err(Error::Program {
                    program: "abc".to_string(),
                    problem: format!("{}: a counterexample that is none: {values:x?}", pair[0].name()),
                    expected: "values for which the simulator sees a difference".to_string(),
                });
            }
            Ok(Equivalence::Different(values))
        }
    }
}

/// What a module's outputs show for these inputs.
fn shown(module: &Arc<Module>, values: &BTreeMap<String, u64>) -> Result<Vec<u64>, Error> {
    let mut simulator = Simulator::new(module)?;
    for port in module.inputs() {
        let input = simulator.input(&port.name)?;
        simulator.set(input, values.get(&port.name).copied().unwrap_or(0));
    }
    simulator.settle();
    let outputs = module.outputs().iter().map(|port| Ok(simulator.get(simulator.output(&port.name)?)));
    outputs.collect()
}
