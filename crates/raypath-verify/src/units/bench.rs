//! A test bench of the floating-point units: one netlist with all units of a format and common operands.

use super::chain::chain;
use raypath_float::{Format, add_parts, compare, decode, encode, mul_parts};
use raypath_hdl::{Builder, Error, InputPort, Module, OutputPort, Simulator, Wire};
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
    /// Which split units differ from the unsplit ones: a bit for each of [`SPLIT_RESULTS`], the first one in bit 0. An
    /// oracle returns 0.
    pub parts_differ: u64,
}

/// The results that split units compute too: units with registers between their parts, here without the registers.
pub const SPLIT_RESULTS: [&str; 6] = [
    "sum in two parts",
    "difference in two parts",
    "product in two parts",
    "sum in three parts",
    "difference in three parts",
    "product in three parts",
];

/// The output ports of a bench, in the order of [`UnitResults`]'s fields.
pub const OUTPUTS: [&str; 7] =
    ["sum_o", "difference_o", "product_o", "less_o", "equal_o", "unordered_o", "parts_differ_o"];

impl UnitResults {
    /// The results from the values of [`OUTPUTS`].
    pub fn from_outputs(outputs: [u64; OUTPUTS.len()]) -> Self {
        let [sum, difference, product, less, equal, unordered, parts_differ] = outputs;
        Self { sum, difference, product, less: less == 1, equal: equal == 1, unordered: unordered == 1, parts_differ }
    }

    /// A line for each result that differs from the expected one; `operands` names the operands.
    pub fn mismatches(self, expected: Self, operands: &str) -> Vec<String> {
        let numbers = [
            ("sum", self.sum, expected.sum),
            ("difference", self.difference, expected.difference),
            ("product", self.product, expected.product),
        ];
        let relations = [
            ("less", self.less, expected.less),
            ("equal", self.equal, expected.equal),
            ("unordered", self.unordered, expected.unordered),
        ];
        let wrong = numbers.into_iter().filter(|(_, found, expected)| found != expected);
        let wrong_numbers =
            wrong.map(|(name, found, expected)| format!("{name} of {operands}: {found:#x}, expected {expected:#x}"));
        let wrong = relations.into_iter().filter(|(_, found, expected)| found != expected);
        let wrong_relations =
            wrong.map(|(name, found, expected)| format!("{name} of {operands}: {found}, expected {expected}"));
        let differing = SPLIT_RESULTS.iter().enumerate().filter(|(bit, _)| self.parts_differ >> bit & 1 == 1);
        let wrong_parts = differing.map(|(_, name)| format!("{name} of {operands}: differs from the unsplit unit"));
        wrong_numbers.chain(wrong_relations).chain(wrong_parts).collect()
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
    /// The comparator.
    pub compare: Arc<Module>,
}

impl Units {
    /// The datapath's units.
    pub fn new(format: Format) -> Result<Self, Error> {
        let [add, mul] = [add_parts, mul_parts].map(|unit| {
            let in_parts = |count| chain(&unit(format, count)?);
            Ok([unit(format, 1)?.remove(0), in_parts(2)?, in_parts(3)?])
        });
        let (encode, decode, compare) = (encode(format)?, decode(format)?, compare(format)?);
        Ok(Self { format, encode, decode, add: add?, mul: mul?, compare })
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
        let differ: Vec<Wire<'_>> = in_parts
            .as_flattened()
            .iter()
            .zip(whole.iter().cycle())
            .map(|(part, whole)| !part.equals(*whole))
            .collect();
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

/// A bench in the netlist simulator.
pub struct Bench {
    simulator: Simulator,
    inputs: [InputPort; 2],
    outputs: [OutputPort; OUTPUTS.len()],
}

impl Bench {
    /// Compiles the bench of these units.
    pub fn new(units: &Units, ports: PortFormat) -> Result<Self, Error> {
        let simulator = Simulator::new(&units.bench(ports)?)?;
        let inputs = [simulator.input("a_i")?, simulator.input("b_i")?];
        let [sum, difference, product, less, equal, unordered, parts_differ] =
            OUTPUTS.map(|name| simulator.output(name));
        let outputs = [sum?, difference?, product?, less?, equal?, unordered?, parts_differ?];
        Ok(Self { simulator, inputs, outputs })
    }

    /// The units' results for two operands.
    pub fn run(&mut self, a: u64, b: u64) -> UnitResults {
        self.simulator.set(self.inputs[0], a);
        self.simulator.set(self.inputs[1], b);
        self.simulator.settle();
        UnitResults::from_outputs(self.outputs.map(|output| self.simulator.get(output)))
    }
}

/// A unit with one input and one output, in the netlist simulator.
pub struct Converter {
    simulator: Simulator,
    input: InputPort,
    output: OutputPort,
}

impl Converter {
    /// Compiles the unit.
    pub fn new(module: &Arc<Module>) -> Result<Self, Error> {
        let simulator = Simulator::new(module)?;
        let first = |ports: &[raypath_hdl::Port]| ports.first().map(|port| port.name.clone()).unwrap_or_default();
        let (input, output) = (simulator.input(&first(module.inputs()))?, simulator.output(&first(module.outputs()))?);
        Ok(Self { simulator, input, output })
    }

    /// The output for an input word.
    pub fn run(&mut self, word: u64) -> u64 {
        self.simulator.set(self.input, word);
        self.simulator.settle();
        self.simulator.get(self.output)
    }
}
