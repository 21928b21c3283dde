//! A test bench of the floating-point units: one netlist with all units of a format and common operands.

use raypath_float::{Format, Product, add, compare, decode, div, encode, mul, sqrt};
use raypath_hdl::{Builder, Error, Module, Simulator, Wire, expose_registers};
use std::sync::Arc;

/// The results of all units for two operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnitResults {
    /// `a + b`.
    pub sum: u64,
    /// `a - b`.
    pub difference: u64,
    /// `a * b`.
    pub product: u64,
    /// `a / b`.
    pub quotient: u64,
    /// The square root of `a`.
    pub root: u64,
    /// `a < b`.
    pub less: bool,
    /// `a = b`.
    pub equal: bool,
    /// An operand is NaN.
    pub unordered: bool,
}

/// The output ports of a bench, in the order of [`UnitResults`]'s fields.
pub const OUTPUTS: [&str; 8] =
    ["sum_o", "difference_o", "product_o", "quotient_o", "root_o", "less_o", "equal_o", "unordered_o"];

impl UnitResults {
    /// The results from the values of [`OUTPUTS`].
    pub fn from_outputs(outputs: [u64; OUTPUTS.len()]) -> Self {
        let [sum, difference, product, quotient, root, less, equal, unordered] = outputs;
        let [less, equal, unordered] = [less, equal, unordered].map(|bit| bit == 1);
        Self { sum, difference, product, quotient, root, less, equal, unordered }
    }

    /// A line for each result that differs from the expected one; `operands` names the operands.
    pub fn mismatches(self, expected: Self, operands: &str) -> Vec<String> {
        let shown = |results: Self| {
            let Self { sum, difference, product, quotient, root, .. } = results;
            let numbers = [sum, difference, product, quotient, root].map(|number| format!("{number:#x}"));
            let relations = [results.less, results.equal, results.unordered].map(|holds| holds.to_string());
            numbers.into_iter().chain(relations)
        };
        let names = OUTPUTS.iter().map(|output| output.trim_end_matches("_o"));
        let pairs = names.zip(shown(self).zip(shown(expected))).filter(|(_, (found, expected))| found != expected);
        pairs.map(|(name, (found, expected))| format!("{name} of {operands}: {found}, expected {expected}")).collect()
    }
}

/// The floating-point units of a format. A test replaces one to insert a fault.
#[derive(Clone)]
pub struct Units {
    /// The number format.
    pub format: Format,
    /// Converts an operand from IEEE 754's format to the recoded one.
    pub encode: Arc<Module>,
    /// Converts a result from the recoded format to IEEE 754's.
    pub decode: Arc<Module>,
    /// The adder.
    pub add: Arc<Module>,
    /// The multiplier.
    pub mul: Arc<Module>,
    /// The divider.
    pub div: Arc<Module>,
    /// The square root.
    pub sqrt: Arc<Module>,
    /// The comparator.
    pub compare: Arc<Module>,
}

impl Units {
    /// The datapath's units.
    pub fn new(format: Format) -> Result<Self, Error> {
        let (encode, decode, compare) = (encode(format)?, decode(format)?, compare(format)?);
        let (add, mul, div, sqrt) =
            (add(format, false)?, mul(format, Product::Booth, false)?, div(format)?, sqrt(format)?);
        Ok(Self { format, encode, decode, add, mul, div, sqrt, compare })
    }

    /// A netlist of all units between the encoding and decoding units, with the inputs `a_i` and `b_i` and the outputs
    /// [`OUTPUTS`]. It subtracts as the datapath does: with the adder, the sign of the recoded `b` inverted.
    pub fn bench(&self) -> Result<Arc<Module>, Error> {
        let m = Builder::new(&format!("bench_{}", self.format));
        let single = |name: &str, unit: &Arc<Module>, inputs: &[(&str, Wire<'_>)]| -> Wire<'_> {
            // A unit with more or fewer outputs gives a word of no bits, which `finish` rejects.
            match m.instance(name, unit, inputs).as_slice() {
                [output] => *output,
                _ => m.constant(0, 0),
            }
        };
        let [a, b] = ["a", "b"].map(|name| {
            let given = m.input(&format!("{name}_i"), self.format.ieee_width());
            single(&format!("encode_{name}"), &self.encode, &[("ieee_i", given)])
        });
        let minus_b = m.concat(&[!b.top(), b.lower(b.width() - 1)]);
        let both = |b| vec![("a_i", a), ("b_i", b)];
        for (name, unit, inputs) in [
            ("sum", &self.add, both(b)),
            ("difference", &self.add, both(minus_b)),
            ("product", &self.mul, both(b)),
            ("quotient", &self.div, both(b)),
            ("root", &self.sqrt, vec![("a_i", a)]),
        ] {
            let result = single(&format!("u_{name}"), unit, &inputs);
            let decoded = single(&format!("decode_{name}"), &self.decode, &[("recoded_i", result)]);
            m.output(&format!("{name}_o"), decoded);
        }
        for (name, wire) in OUTPUTS[5..].iter().zip(m.instance("compare", &self.compare, &both(b))) {
            m.output(name, wire);
        }
        m.finish()
    }
}

/// Joins the parts of a split unit, without the registers between them: a module with the inputs of the first part and
/// the outputs of the last. The output `x_o` of a part drives the input `x_i` of the next part.
///
/// # Errors
/// An output without such an input, or an input without such an output.
pub fn chain(parts: &[Arc<Module>]) -> Result<Arc<Module>, Error> {
    let name = parts.first().map_or("no_part", |part| part.name());
    let m = Builder::new(&format!("chain_of_{name}"));
    let inputs = parts.iter().take(1).flat_map(|first| first.inputs().iter().map(move |port| (first, &port.name)));
    let mut values: Vec<(String, Wire<'_>)> =
        inputs.map(|(first, name)| (name.clone(), m.input(name, first.port_width(name).unwrap_or_default()))).collect();
    for (index, part) in parts.iter().enumerate() {
        if let Some((name, _)) = values.iter().find(|(name, _)| part.inputs().iter().all(|port| port.name != *name)) {
            return Err(Error::Name {
                module: part.name().to_string(),
                name: name.clone(),
                problem: "is not an input of this part, but an output of the part before".to_string(),
            });
        }
        let connected: Vec<(&str, Wire<'_>)> = values.iter().map(|(name, wire)| (name.as_str(), *wire)).collect();
        let outputs = m.instance(&format!("u_part_{}", index + 1), part, &connected);
        let stems = part.outputs().iter().map(|port| port.name.strip_suffix("_o").unwrap_or(&port.name));
        values = stems.map(|stem| format!("{stem}_i")).zip(outputs).collect();
    }
    for (port, (_, wire)) in parts.iter().next_back().into_iter().flat_map(|last| last.outputs()).zip(values) {
        m.output(&port.name, wire);
    }
    m.finish()
}

/// An iterative unit over `cycles` cycles, without registers: the result for operands that it takes when it is idle. In
/// the cycles after, it is offered the inverted operands. Inputs are the operands and, for each register `x_q` without
/// a reset, its first value `state_x_q`. The output is `result_o`, and its inverse if the result is not valid.
///
/// # Errors
/// The unit lacks a port of [`DivSqrt::iterative`](raypath_float::DivSqrt::iterative).
pub fn unrolled(unit: &Arc<Module>, cycles: u32) -> Result<Arc<Module>, Error> {
    let exposed = expose_registers(unit);
    let m = Builder::new(&format!("unrolled_{}", unit.name()));
    let width = |name: &str| exposed.port_width(name).unwrap_or_default();
    let is_control = |name: &str| matches!(name, "valid_i" | "ready_i");
    let names = || unit.inputs().iter().map(|port| port.name.as_str());
    let operands: Vec<(&str, Wire<'_>)> =
        names().filter(|name| !is_control(name)).map(|name| (name, m.input(name, width(name)))).collect();
    let first = |name: &str, has_reset: bool| {
        if has_reset { m.constant(width(name), 0) } else { m.input(&format!("state_{name}"), width(name)) }
    };
    let registers = exposed.inputs()[unit.inputs().len()..].iter().zip(unit.registers());
    let mut state: Vec<(&str, Wire<'_>)> =
        registers.map(|(port, register)| (port.name.as_str(), first(&port.name, register.reset.is_some()))).collect();
    let mut shown = [m.constant(1, 0), m.constant(1, 0)];
    for cycle in 0..=cycles {
        let offered = operands.iter().map(|&(name, wire)| (name, if cycle == 0 { wire } else { !wire }));
        let control = [("valid_i", m.constant(1, 1)), ("ready_i", m.constant(1, 0))];
        let inputs: Vec<(&str, Wire<'_>)> = offered.chain(control).chain(state.iter().copied()).collect();
        let outputs = m.instance(&format!("u_cycle_{cycle}"), &exposed, &inputs);
        let output = |name: &str| {
            let place = exposed.outputs().iter().position(|port| port.name == name);
            place.map_or_else(|| m.constant(1, 0), |place| outputs[place])
        };
        state = state.iter().map(|&(name, _)| (name, output(&format!("next_{name}")))).collect();
        shown = ["valid_o", "result_o"].map(output);
    }
    let [valid, result] = shown;
    m.output("result_o", valid.mux(result, !result));
    m.finish()
}

/// A bench in the netlist simulator.
pub struct Bench(Simulator);

impl Bench {
    /// Compiles the bench of these units.
    pub fn new(units: &Units) -> Result<Self, Error> {
        Simulator::new(&units.bench()?).map(Self)
    }

    /// The units' results for two operands.
    pub fn run(&mut self, a: u64, b: u64) -> UnitResults {
        let outputs = self.0.evaluate([a, b]);
        UnitResults::from_outputs(std::array::from_fn(|place| outputs[place]))
    }
}
