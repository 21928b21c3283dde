//! The floating-point units in one netlist, with operands in common: what campaigns and the units' own tests run.

mod chain;

pub use chain::chain;

use raypath_float::{Format, add_parts, compare, decode, encode, mul_parts};
use raypath_hdl::{Builder, Error, InputPort, Module, OutputPort, Simulator, Wire};
use std::sync::Arc;

/// What the units say of two operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Answer {
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
    /// One of them is NaN.
    pub unordered: bool,
    /// Which of the units in parts answer something else than the whole ones: a bit for each of [`IN_PARTS`], the first
    /// in the lowest place. An oracle says 0.
    pub parts_differ: u64,
}

/// The results that are computed in parts too.
pub const IN_PARTS: [&str; 6] = [
    "sum in two parts",
    "difference in two parts",
    "product in two parts",
    "sum in three parts",
    "difference in three parts",
    "product in three parts",
];

/// The outputs of a bench, in the order of [`Answer`].
pub const OUTPUTS: [&str; 7] =
    ["sum_o", "difference_o", "product_o", "less_o", "equal_o", "unordered_o", "parts_differ_o"];

impl Answer {
    /// From the outputs in the order of [`OUTPUTS`].
    pub fn of(outputs: [u64; OUTPUTS.len()]) -> Self {
        let [sum, difference, product, less, equal, unordered, parts_differ] = outputs;
        Self { sum, difference, product, less: less == 1, equal: equal == 1, unordered: unordered == 1, parts_differ }
    }

    /// What is wrong with it in words, a line for each result; `operands` says of what.
    pub fn faults(self, expected: Self, operands: &str) -> Vec<String> {
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
        let wrong = numbers.into_iter().filter(|(_, seen, expected)| seen != expected);
        let wrong_numbers =
            wrong.map(|(name, seen, expected)| format!("{name} of {operands}: {seen:#x}, expected {expected:#x}"));
        let wrong = relations.into_iter().filter(|(_, seen, expected)| seen != expected);
        let wrong_relations =
            wrong.map(|(name, seen, expected)| format!("{name} of {operands}: {seen}, expected {expected}"));
        let differing = IN_PARTS.iter().enumerate().filter(|(place, _)| self.parts_differ >> place & 1 == 1);
        let wrong_parts = differing.map(|(_, name)| format!("{name} of {operands}: not what the whole unit gives"));
        wrong_numbers.chain(wrong_relations).chain(wrong_parts).collect()
    }
}

/// The two ways to present operands to the units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ports {
    /// In IEEE 754's layout, through the units that encode and decode.
    Ieee,
    /// Recoded, directly.
    Recoded,
}

/// The units of a format, each to be replaced by whoever wants to see a fault found.
#[derive(Clone)]
pub struct Units {
    /// The format.
    pub format: Format,
    /// Recodes an operand.
    pub encode: Arc<Module>,
    /// Gives a result IEEE 754's layout.
    pub decode: Arc<Module>,
    /// The adder: whole, and put together from two and from three parts.
    pub add: [Arc<Module>; 3],
    /// The multiplier, likewise.
    pub mul: [Arc<Module>; 3],
    /// The comparator.
    pub compare: Arc<Module>,
}

impl Units {
    /// The units as the datapath has them.
    pub fn of(format: Format) -> Result<Self, Error> {
        let [add, mul] = [add_parts, mul_parts].map(|unit| {
            let in_parts = |count| chain(&unit(format, count)?);
            Ok([unit(format, 1)?.remove(0), in_parts(2)?, in_parts(3)?])
        });
        let (encode, decode, compare) = (encode(format)?, decode(format)?, compare(format)?);
        Ok(Self { format, encode, decode, add: add?, mul: mul?, compare })
    }

    /// A netlist that holds them all with two operands `a_i` and `b_i` in common, and has the outputs [`OUTPUTS`]. A
    /// difference is what the datapath makes of one: the adder once more, `b`'s sign inverted in its recoded form.
    pub fn bench(&self, ports: Ports) -> Result<Arc<Module>, Error> {
        let (name, width) = match ports {
            Ports::Ieee => ("ieee", self.format.ieee_width()),
            Ports::Recoded => ("recoded", self.format.recoded_width()),
        };
        let m = Builder::new(&format!("bench_{name}_{}", self.format));
        let operand = |name: &str| {
            let given = m.input(&format!("{name}_i"), width);
            match ports {
                Ports::Ieee => only(&m, m.instance(&format!("encode_{name}"), &self.encode, &[("ieee_i", given)])),
                Ports::Recoded => given,
            }
        };
        let (a, b) = (operand("a"), operand("b"));
        let minus_b = m.concat(&[!b.top(), b.lower(b.width() - 1)]);
        let results = |count: usize| {
            let [add, mul] = [&self.add[count - 1], &self.mul[count - 1]];
            [("sum", add, b), ("difference", add, minus_b), ("product", mul, b)].map(|(name, unit, b)| {
                only(&m, m.instance(&format!("{name}_in_{count}"), unit, &[("a_i", a), ("b_i", b)]))
            })
        };

        let whole = results(1);
        for (name, wire) in ["sum", "difference", "product"].into_iter().zip(whole) {
            let result = match ports {
                Ports::Ieee => only(&m, m.instance(&format!("decode_{name}"), &self.decode, &[("recoded_i", wire)])),
                Ports::Recoded => wire,
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

/// The only output of a unit; of a unit with another number of outputs, a word that no bench can be finished with.
fn only<'m>(m: &'m Builder, outputs: Vec<Wire<'m>>) -> Wire<'m> {
    match outputs.as_slice() {
        [output] => *output,
        _ => m.constant(0, 0),
    }
}

/// A bench in simulation.
pub struct Bench {
    simulator: Simulator,
    inputs: [InputPort; 2],
    outputs: [OutputPort; OUTPUTS.len()],
}

impl Bench {
    /// Compiles the bench of some units.
    pub fn new(units: &Units, ports: Ports) -> Result<Self, Error> {
        let simulator = Simulator::new(&units.bench(ports)?)?;
        let inputs = [simulator.input("a_i")?, simulator.input("b_i")?];
        let [sum, difference, product, less, equal, unordered, parts_differ] =
            OUTPUTS.map(|name| simulator.output(name));
        let outputs = [sum?, difference?, product?, less?, equal?, unordered?, parts_differ?];
        Ok(Self { simulator, inputs, outputs })
    }

    /// What the units say of two operands.
    pub fn run(&mut self, a: u64, b: u64) -> Answer {
        self.simulator.set(self.inputs[0], a);
        self.simulator.set(self.inputs[1], b);
        self.simulator.settle();
        Answer::of(self.outputs.map(|output| self.simulator.get(output)))
    }
}

/// A unit alone of one input and one output, in simulation.
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

    /// What it makes of a word.
    pub fn run(&mut self, word: u64) -> u64 {
        self.simulator.set(self.input, word);
        self.simulator.settle();
        self.simulator.get(self.output)
    }
}
