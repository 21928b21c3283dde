//! Modules around the units, and running them.

use raypath_float::{Format, add, add_parts, compare, decode, encode, mul, mul_parts};
use raypath_hdl::{Builder, Error, Module, Simulator, Wire};
use raypath_verify::chain;
use raypath_verify::operands::Answer;
use std::sync::Arc;

/// What the units say, from the outputs in the order of [`OUTPUTS`].
pub fn answer_of(outputs: &[u64]) -> Answer {
    let [sum, product, less, equal, unordered, parts_agree] = outputs.try_into().expect("all outputs of a bench");
    assert_eq!(parts_agree, 1, "a unit in parts answers something else than {sum:#x} or {product:#x}");
    Answer { sum, product, less: less == 1, equal: equal == 1, unordered: unordered == 1 }
}

/// The two ways to present operands to the units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ports {
    /// Through encoders and decoders.
    Ieee,
    /// Directly.
    Recoded,
}

/// One netlist that holds an adder, a multiplier, both of them again in two and in three parts, and a comparator, with
/// two operands in common.
pub struct Bench {
    simulator: Simulator,
    inputs: [raypath_hdl::InputPort; 2],
    outputs: [raypath_hdl::OutputPort; 6],
}

impl Bench {
    pub fn new(format: Format, ports: Ports) -> Self {
        let module = module(format, ports).expect("the bench builds");
        let simulator = Simulator::new(&module).expect("the bench runs");
        let inputs = ["a_i", "b_i"].map(|name| simulator.input(name).expect("an input"));
        let outputs = OUTPUTS.map(|name| simulator.output(name).expect("an output"));
        Self { simulator, inputs, outputs }
    }

    pub fn run(&mut self, a: u64, b: u64) -> Answer {
        self.simulator.set(self.inputs[0], a);
        self.simulator.set(self.inputs[1], b);
        self.simulator.settle();
        answer_of(&self.outputs.map(|output| self.simulator.get(output)))
    }
}

/// A converter alone: one word in, one word out.
pub struct Converter {
    simulator: Simulator,
    input: raypath_hdl::InputPort,
    output: raypath_hdl::OutputPort,
}

impl Converter {
    pub fn new(module: Result<Arc<Module>, Error>) -> Self {
        let module = module.expect("the converter builds");
        let simulator = Simulator::new(&module).expect("the converter runs");
        let input = simulator.input(&module.inputs()[0].name).expect("its input");
        let output = simulator.output(&module.outputs()[0].name).expect("its output");
        Self { simulator, input, output }
    }

    pub fn run(&mut self, word: u64) -> u64 {
        self.simulator.set(self.input, word);
        self.simulator.settle();
        self.simulator.get(self.output)
    }
}

/// The outputs of a bench, in the order of [`answer_of`].
pub const OUTPUTS: [&str; 6] = ["sum_o", "product_o", "less_o", "equal_o", "unordered_o", "parts_agree_o"];

/// The netlist of a bench.
pub fn module(format: Format, ports: Ports) -> Result<Arc<Module>, Error> {
    let (name, width) = match ports {
        Ports::Ieee => ("ieee", format.ieee_width()),
        Ports::Recoded => ("recoded", format.recoded_width()),
    };
    let m = Builder::new(&format!("bench_{name}_{format}"));
    let (a, b) = (m.input("a_i", width), m.input("b_i", width));
    let (encoder, decoder) = (encode(format)?, decode(format)?);
    let take = |name: &str, wire| match ports {
        Ports::Ieee => only(m.instance(name, &encoder, &[("ieee_i", wire)])),
        Ports::Recoded => wire,
    };
    let give = |name: &str, wire| match ports {
        Ports::Ieee => only(m.instance(name, &decoder, &[("recoded_i", wire)])),
        Ports::Recoded => wire,
    };
    let (a, b) = (take("encode_a", a), take("encode_b", b));
    let operands = [("a_i", a), ("b_i", b)];
    let sum = only(m.instance("add", &add(format)?, &operands));
    let product = only(m.instance("mul", &mul(format)?, &operands));
    let relation = m.instance("compare", &compare(format)?, &operands);
    m.output(OUTPUTS[0], give("decode_sum", sum));
    m.output(OUTPUTS[1], give("decode_product", product));
    for (name, wire) in OUTPUTS[2..5].iter().zip(relation) {
        m.output(name, wire);
    }
    let mut agree = m.constant(1, 1);
    for count in 2..=3 {
        let chains = [(&add_parts(format, count)?, sum), (&mul_parts(format, count)?, product)];
        for ((parts, whole), kind) in chains.into_iter().zip(["add", "mul"]) {
            let result = only(m.instance(&format!("{kind}_in_{count}"), &chain(parts)?, &operands));
            agree = agree & result.equals(whole);
        }
    }
    m.output(OUTPUTS[5], agree);
    m.finish()
}

fn only(outputs: Vec<Wire<'_>>) -> Wire<'_> {
    assert_eq!(outputs.len(), 1);
    outputs[0]
}
