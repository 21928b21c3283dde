//! A test bench of the floating-point units: one netlist with all units of a format and common operands.

use raypath_float::{Format, add_parts, compare, decode, encode, mul_inferred_parts, mul_parts};
use raypath_hdl::{Builder, Error, InputPort, Module, OutputPort, Simulator, Wire, expose_registers};
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
    /// `a < b`.
    pub less: bool,
    /// `a = b`.
    pub equal: bool,
    /// An operand is NaN.
    pub unordered: bool,
    /// Which other forms of units differ from the unsplit ones: a bit for each of [`OTHER_RESULTS`], the first one in
    /// bit 0. An oracle returns 0.
    pub others_differ: u64,
}

/// The results that other forms of units compute too: units with registers between their parts, here without the
/// registers, and the multiplier with `*`.
pub const OTHER_RESULTS: [&str; 9] = [
    "sum in two parts",
    "difference in two parts",
    "product in two parts",
    "sum in three parts",
    "difference in three parts",
    "product in three parts",
    "product with *",
    "product with * in two parts",
    "product with * in three parts",
];

/// The output ports of a bench, in the order of [`UnitResults`]'s fields.
pub const OUTPUTS: [&str; 7] =
    ["sum_o", "difference_o", "product_o", "less_o", "equal_o", "unordered_o", "others_differ_o"];

impl UnitResults {
    /// The results from the values of [`OUTPUTS`].
    pub fn from_outputs(outputs: [u64; OUTPUTS.len()]) -> Self {
        let [sum, difference, product, less, equal, unordered, others_differ] = outputs;
        Self { sum, difference, product, less: less == 1, equal: equal == 1, unordered: unordered == 1, others_differ }
    }

    /// A line for each result that differs from the expected one; `operands` names the operands.
    pub fn mismatches(self, expected: Self, operands: &str) -> Vec<String> {
        let shown = |results: Self| {
            let numbers = [results.sum, results.difference, results.product].map(|number| format!("{number:#x}"));
            let relations = [results.less, results.equal, results.unordered].map(|holds| holds.to_string());
            numbers.into_iter().chain(relations)
        };
        let names = ["sum", "difference", "product", "less", "equal", "unordered"];
        let pairs =
            names.iter().zip(shown(self).zip(shown(expected))).filter(|(_, (found, expected))| found != expected);
        let wrong =
            pairs.map(|(name, (found, expected))| format!("{name} of {operands}: {found}, expected {expected}"));
        let differing = OTHER_RESULTS.iter().enumerate().filter(|(bit, _)| self.others_differ >> bit & 1 == 1);
        let wrong_others = differing.map(|(_, name)| format!("{name} of {operands}: differs from the unsplit unit"));
        wrong.chain(wrong_others).collect()
    }
}

/// The encoding of a bench's operands and results.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PortFormat {
    /// IEEE 754's interchange format, converted by the encoding and decoding units.
    Ieee,
    /// The recoded format, without conversion.
    Recoded,
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
    /// The adder: unsplit, and joined from two and from three parts.
    pub add: [Arc<Module>; 3],
    /// The multiplier: unsplit, and joined from two and from three parts.
    pub mul: [Arc<Module>; 3],
    /// The multiplier with `*`, likewise.
    pub mul_inferred: [Arc<Module>; 3],
    /// The comparator.
    pub compare: Arc<Module>,
}

impl Units {
    /// The datapath's units.
    pub fn new(format: Format) -> Result<Self, Error> {
        Self::of(format, false)
    }

    /// The units of a datapath with exception flags.
    pub fn with_flags(format: Format) -> Result<Self, Error> {
        Self::of(format, true)
    }

    fn of(format: Format, with_flags: bool) -> Result<Self, Error> {
        let [add, mul, mul_inferred] = [add_parts, mul_parts, mul_inferred_parts].map(|unit| {
            let in_parts = |count| chain(&unit(format, count, with_flags)?);
            Ok([unit(format, 1, with_flags)?.remove(0), in_parts(2)?, in_parts(3)?])
        });
        let (encode, decode, compare) = (encode(format)?, decode(format)?, compare(format)?);
        Ok(Self { format, encode, decode, add: add?, mul: mul?, mul_inferred: mul_inferred?, compare })
    }

    /// A netlist of all units, with the inputs `a_i` and `b_i` and the outputs [`OUTPUTS`]. It subtracts as the
    /// datapath does: with the adder, the sign of the recoded `b` inverted.
    pub fn bench(&self, ports: PortFormat) -> Result<Arc<Module>, Error> {
        let (name, width) = match ports {
            PortFormat::Ieee => ("ieee", self.format.ieee_width()),
            PortFormat::Recoded => ("recoded", self.format.recoded_width()),
        };
        let m = Builder::new(&format!("bench_{name}_{}", self.format));
        let operand = |name: &str| {
            let given = m.input(&format!("{name}_i"), width);
            match ports {
                PortFormat::Ieee => {
                    single_output(&m, m.instance(&format!("encode_{name}"), &self.encode, &[("ieee_i", given)]))
                }
                PortFormat::Recoded => given,
            }
        };
        let (a, b) = (operand("a"), operand("b"));
        let minus_b = m.concat(&[!b.top(), b.lower(b.width() - 1)]);
        let results = |count: usize| {
            let [add, mul] = [&self.add[count - 1], &self.mul[count - 1]];
            [("sum", add, b), ("difference", add, minus_b), ("product", mul, b)].map(|(name, unit, b)| {
                single_output(&m, m.instance(&format!("{name}_in_{count}"), unit, &[("a_i", a), ("b_i", b)]))
            })
        };

        let whole = results(1);
        for (name, wire) in ["sum", "difference", "product"].into_iter().zip(whole) {
            let result = match ports {
                PortFormat::Ieee => {
                    single_output(&m, m.instance(&format!("decode_{name}"), &self.decode, &[("recoded_i", wire)]))
                }
                PortFormat::Recoded => wire,
            };
            m.output(&format!("{name}_o"), result);
        }
        for (name, wire) in OUTPUTS[3..6].iter().zip(m.instance("compare", &self.compare, &[("a_i", a), ("b_i", b)])) {
            m.output(name, wire);
        }
        let in_parts = [2, 3].map(results);
        let in_parts = in_parts.as_flattened().iter().copied().zip(whole.into_iter().cycle());
        let inferred = (1..).zip(&self.mul_inferred).map(|(count, unit)| {
            let name = format!("product_inferred_in_{count}");
            (single_output(&m, m.instance(&name, unit, &[("a_i", a), ("b_i", b)])), whole[2])
        });
        let differ: Vec<Wire<'_>> = in_parts.chain(inferred).map(|(other, whole)| !other.equals(whole)).collect();
        m.output(OUTPUTS[6], m.concat(&differ.into_iter().rev().collect::<Vec<_>>()));
        m.finish()
    }
}

/// A unit's only output. For a unit with more or fewer outputs it is a word of no bits, which `finish` rejects.
fn single_output<'m>(m: &'m Builder, outputs: Vec<Wire<'m>>) -> Wire<'m> {
    match outputs.as_slice() {
        [output] => *output,
        _ => m.constant(0, 0),
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
pub struct Bench(Simulated);

impl Bench {
    /// Compiles the bench of these units.
    pub fn new(units: &Units, ports: PortFormat) -> Result<Self, Error> {
        Simulated::new(&units.bench(ports)?).map(Self)
    }

    /// The units' results for two operands.
    pub fn run(&mut self, a: u64, b: u64) -> UnitResults {
        UnitResults::from_outputs(self.0.run([a, b]))
    }
}

/// A combinational module in the netlist simulator.
pub struct Simulated {
    simulator: Simulator,
    inputs: Vec<InputPort>,
    outputs: Vec<OutputPort>,
}

impl Simulated {
    /// Compiles the module.
    pub fn new(module: &Arc<Module>) -> Result<Self, Error> {
        let simulator = Simulator::new(module)?;
        let inputs = module.inputs().iter().map(|port| simulator.input(&port.name)).collect::<Result<_, _>>()?;
        let outputs = module.outputs().iter().map(|port| simulator.output(&port.name)).collect::<Result<_, _>>()?;
        Ok(Self { simulator, inputs, outputs })
    }

    /// The first outputs for these inputs, in the order of the ports; 0 for outputs that the module lacks.
    pub fn run<const N: usize>(&mut self, inputs: impl IntoIterator<Item = u64>) -> [u64; N] {
        self.inputs.iter().zip(inputs).for_each(|(input, word)| self.simulator.set(*input, word));
        self.simulator.settle();
        std::array::from_fn(|index| self.outputs.get(index).map_or(0, |output| self.simulator.get(*output)))
    }
}
