//! Dividers with conversions in the netlist simulator, with operands in every cycle in which they take some.

use crate::units::answers::Answers;
use raypath_float::{DivSqrt, Format, decode, encode};
use raypath_hdl::{Builder, InputPort, Module, OutputPort, Simulator, Wire};
use raypath_verify::Error;
use std::sync::Arc;

/// A clocked unit: a pipelined or an iterative one, without a tag.
#[derive(Debug, Clone)]
pub struct Divider {
    /// What it computes.
    pub function: DivSqrt,
    /// The unit, with recoded operands.
    pub module: Arc<Module>,
}

/// The dividers of a format. A test replaces one to insert a fault.
#[derive(Debug, Clone)]
pub struct Dividers {
    /// The number format.
    pub format: Format,
    /// Pipelined and iterative units of all functions.
    pub units: Vec<Divider>,
}

impl Dividers {
    /// Every function pipelined and iterative, with various latencies and digits a cycle.
    pub fn new(format: Format) -> Result<Self, Error> {
        let most = format.significand() + 3;
        let pipelined = [
            (DivSqrt::Quotient, 1),
            (DivSqrt::Quotient, most.div_ceil(2)),
            (DivSqrt::Reciprocal, 1),
            (DivSqrt::Root, 1),
            (DivSqrt::QuotientOrRoot, most),
        ];
        let iterative =
            [(DivSqrt::Quotient, 2), (DivSqrt::Reciprocal, 3), (DivSqrt::Root, 2), (DivSqrt::QuotientOrRoot, 1)];
        let pipelined = pipelined.map(|(function, latency)| (function, function.pipelined(format, latency, 0)));
        let iterative = iterative.map(|(function, digits)| (function, function.iterative(format, digits, 0)));
        let units = pipelined.into_iter().chain(iterative);
        let units = units.map(|(function, module)| Ok(Divider { function, module: module? }));
        Ok(Self { format, units: units.collect::<Result<_, Error>>()? })
    }

    /// The units in simulation.
    pub(super) fn streams(&self) -> Result<Vec<Stream>, Error> {
        self.units.iter().map(|divider| Stream::new(self.format, divider)).collect()
    }
}

/// A divider in simulation.
pub(super) struct Stream {
    function: DivSqrt,
    simulator: Simulator,
    valid: InputPort,
    a: Option<InputPort>,
    b: Option<InputPort>,
    is_root: Option<InputPort>,
    /// Ready, valid, result.
    outputs: [OutputPort; 3],
}

/// Cycles without a result after which a unit counts as stuck: more than any latency.
const STUCK: u32 = 100;

impl Stream {
    fn new(format: Format, divider: &Divider) -> Result<Self, Error> {
        let mut simulator = Simulator::new(&converted(format, &divider.module)?)?;
        simulator.set(simulator.input("ready_i")?, 1);
        let port = |name| simulator.input(name).ok();
        Ok(Self {
            function: divider.function,
            valid: simulator.input("valid_i")?,
            a: port("a_i"),
            b: port("b_i"),
            is_root: port("is_root_i"),
            outputs: [simulator.output("ready_o")?, simulator.output("valid_o")?, simulator.output("result_o")?],
            simulator,
        })
    }

    /// A line for each result that differs from the expected one. A unit for both functions takes the root of the
    /// operands with odd numbers.
    pub fn mismatches(&mut self, operands: &[(u64, u64)], answers: &[Answers]) -> Vec<String> {
        let results = self.run(operands);
        let unit = self.simulator.module().name().to_string();
        if results.len() < operands.len() {
            return vec![format!("{unit}: {} results for {} operands", results.len(), operands.len())];
        }
        let pairs = operands.iter().zip(answers).zip(results).enumerate();
        let wrong = pairs.filter_map(|(number, ((&(a, b), answers), found))| {
            let (what, expected) = match self.function {
                DivSqrt::Reciprocal => (format!("1 / {b:#x}"), answers.reciprocal),
                DivSqrt::Root => (format!("root of {a:#x}"), answers.root),
                DivSqrt::QuotientOrRoot if number % 2 == 1 => (format!("root of {a:#x}"), answers.root),
                DivSqrt::Quotient | DivSqrt::QuotientOrRoot => (format!("{a:#x} / {b:#x}"), answers.quotient),
            };
            (found != expected).then(|| format!("{unit}: {what}: {found:#x}, expected {expected:#x}"))
        });
        wrong.collect()
    }

    /// The results, in order; fewer if the unit is stuck.
    fn run(&mut self, operands: &[(u64, u64)]) -> Vec<u64> {
        let mut results = Vec::with_capacity(operands.len());
        let (mut sent, mut idle) = (0, 0);
        while results.len() < operands.len() && idle < STUCK {
            let (a, b) = operands.get(sent).copied().unwrap_or_default();
            let is_root = sent as u64 % 2;
            self.simulator.set(self.valid, (sent < operands.len()).into());
            for (port, word) in [(self.a, a), (self.b, b), (self.is_root, is_root)] {
                port.into_iter().for_each(|port| self.simulator.set(port, word));
            }
            self.simulator.cycle();
            let [ready, valid, result] = self.outputs.map(|output| self.simulator.get(output));
            sent += usize::from(ready == 1 && sent < operands.len());
            idle += 1;
            if valid == 1 {
                results.push(result);
                idle = 0;
            }
        }
        results
    }
}

/// The unit with operands and results in IEEE 754's layout.
fn converted(format: Format, unit: &Arc<Module>) -> Result<Arc<Module>, raypath_hdl::Error> {
    let m = Builder::new(&format!("converted_{}", unit.name()));
    let (encode, decode) = (encode(format)?, decode(format)?);
    let operand = |name: &str| -> Wire<'_> {
        if !matches!(name, "a_i" | "b_i") {
            return m.input(name, 1);
        }
        m.instance(&format!("u_encode_{name}"), &encode, &[("ieee_i", m.input(name, format.ieee_width()))])[0]
    };
    let inputs: Vec<(&str, Wire<'_>)> =
        unit.inputs().iter().map(|port| (port.name.as_str(), operand(&port.name))).collect();
    let outputs = m.instance("u_unit", unit, &inputs);
    for (port, wire) in unit.outputs().iter().zip(outputs) {
        let is_result = port.name == "result_o";
        let shown = if is_result { m.instance("u_decode", &decode, &[("recoded_i", wire)])[0] } else { wire };
        m.output(&port.name, shown);
    }
    m.finish()
}
