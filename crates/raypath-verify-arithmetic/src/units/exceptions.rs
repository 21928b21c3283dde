//! A test bench of the units with exception flags.

use super::bench::{Simulated, Units};
use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// The functions of a bench.
pub const FUNCTIONS: [&str; 3] = ["sum", "difference", "product"];

/// A function's result and the exceptions that it raises, as bits of [`raypath_float::flags`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Flagged {
    pub number: u64,
    pub flags: u64,
}

/// The units with flags between the encoding and decoding units, in the netlist simulator.
pub struct FlagBench(Simulated);

impl FlagBench {
    /// Compiles the bench of units with flags.
    pub fn new(units: &Units) -> Result<Self, Error> {
        Simulated::new(&bench(units)?).map(Self)
    }

    /// The results of [`FUNCTIONS`] for two operands, and how many split units or multipliers with `*` differ from the
    /// unsplit units.
    pub fn run(&mut self, a: u64, b: u64) -> ([Flagged; FUNCTIONS.len()], u32) {
        let [sum, sum_flags, difference, difference_flags, product, product_flags, differ] = self.0.run([a, b]);
        let results = [(sum, sum_flags), (difference, difference_flags), (product, product_flags)];
        (results.map(|(number, flags)| Flagged { number, flags }), differ.count_ones())
    }
}

fn bench(units: &Units) -> Result<Arc<Module>, Error> {
    let m = Builder::new(&format!("bench_flags_{}", units.format));
    let operand = |name: &str| {
        let given = m.input(&format!("{name}_i"), units.format.ieee_width());
        first(&m, &m.instance(&format!("encode_{name}"), &units.encode, &[("ieee_i", given)]))
    };
    let (a, b) = (operand("a"), operand("b"));
    let minus_b = m.concat(&[!b.top(), b.lower(b.width() - 1)]);
    let mut differ = Vec::new();
    for (function, b, forms) in [
        ("sum", b, units.add.iter().collect::<Vec<_>>()),
        ("difference", minus_b, units.add.iter().collect()),
        ("product", b, units.mul.iter().chain(&units.mul_inferred).collect()),
    ] {
        let results: Vec<Vec<Wire<'_>>> = forms
            .iter()
            .enumerate()
            .map(|(form, unit)| m.instance(&format!("{function}_{form}"), unit, &[("a_i", a), ("b_i", b)]))
            .collect();
        let whole = &results[0];
        let decoded = m.instance(&format!("decode_{function}"), &units.decode, &[("recoded_i", first(&m, whole))]);
        m.output(&format!("{function}_o"), first(&m, &decoded));
        m.output(&format!("{function}_flags_o"), whole.get(1).copied().unwrap_or_else(|| m.constant(0, 0)));
        let whole = m.concat(whole);
        differ.extend(results[1..].iter().map(|other| !m.concat(other).equals(whole)));
    }
    m.output("differ_o", m.concat(&differ));
    m.finish()
}

/// The first output of a unit. Without one it is a word of no bits, which `finish` rejects.
fn first<'m>(m: &'m Builder, outputs: &[Wire<'m>]) -> Wire<'m> {
    outputs.first().copied().unwrap_or_else(|| m.constant(0, 0))
}
