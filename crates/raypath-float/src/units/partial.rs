//! A product as the sum of products for the multipliers of FPGAs.
//!
//! Factors are cut into pieces of 18 bits. Each pair of pieces has a multiplier, but a pair of at most 6 bits each, as
//! of two significands of binary32, has gates: a product takes three multipliers and not four.

use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// The bits of an operand of a multiplier.
const BITS: u32 = 18;

/// The most bits of operands whose product is in gates.
const GATE_BITS: u32 = 6;

/// The product of two words, as wide as both together.
pub fn product<'m>(a: Wire<'m>, b: Wire<'m>) -> Wire<'m> {
    of_pieces(a, b, BITS)
}

/// The product of two words, of products of pieces of so many bits.
fn of_pieces<'m>(a: Wire<'m>, b: Wire<'m>, bits: u32) -> Wire<'m> {
    let m = a.builder();
    let width = a.width() + b.width();
    // The products of pieces of equal numbers are side by side; the others are added to them.
    let (mut beside, mut rows) = (Vec::new(), Vec::new());
    for (i, &left) in pieces(a, bits).iter().enumerate() {
        for (j, &right) in pieces(b, bits).iter().enumerate() {
            let product = product_of_two(m, left, right, &format!("{i}_{j}"));
            if i == j {
                beside.insert(0, product);
            } else {
                rows.push(Row { low: bits * (i + j) as u32, word: product });
            }
        }
    }
    let mut sum = Row { low: 0, word: m.concat(&beside) };
    while rows.len() > 1 {
        let [first, second] = [rows.remove(0), rows.remove(0)];
        rows.push(first.plus(second, width));
    }
    if let Some(row) = rows.pop() {
        sum = sum.plus(row, width);
    }
    let missing = width - sum.word.width();
    if missing == 0 { sum.word } else { m.concat(&[m.constant(missing, 0), sum.word]) }
}

/// A multiplier with a register at each input and one at its output, which a design can replace by a primitive of its
/// FPGA: the module `raypath_mul_18x18`, or, for at most 6 by 6 bits, one of gates.
///
/// # Errors
/// None for widths of 1 to 18 bits.
pub fn multiplier(width: u32, other: u32) -> Result<Arc<Module>, Error> {
    let m = Builder::new(&format!("raypath_mul_{width}x{other}"));
    let is_in_gates = width.max(other) <= GATE_BITS;
    m.doc(match is_in_gates {
        true => "Multiplier of gates with registers before and behind it.",
        false => "Multiplier with registers before and behind it: for a primitive of an FPGA.",
    });
    let [a, b] = [("a", width), ("b", other)].map(|(name, width)| {
        let register = m.register(&format!("{name}_q"), width);
        register.next(m.input(&format!("{name}_i"), width));
        register.wire()
    });
    let product = m.register("product_q", width + other);
    product.next(if is_in_gates { in_gates(&m, a, b) } else { a * b });
    m.output("product_o", product.wire());
    m.finish()
}

/// A word of a sum, and the place of its lowest bit.
#[derive(Clone, Copy)]
struct Row<'m> {
    low: u32,
    word: Wire<'m>,
}

impl<'m> Row<'m> {
    /// The sum of both, without bits from `width` on, which are zeros.
    fn plus(self, other: Self, width: u32) -> Self {
        let (lower, upper) = if self.low <= other.low { (self, other) } else { (other, self) };
        let passed = upper.low - lower.low;
        let [end, upper_end] = [lower, upper].map(|row| row.low + row.word.width());
        let bits = (end.max(upper_end) + 1).min(width) - upper.low;
        let word = lower.word.extend(lower.word.width().max(passed + 1));
        let above = word.upper(word.width() - passed);
        let sum = (above.extend(bits) + upper.word.extend(bits)).hint(&format!("sum_from_{}", upper.low));
        let word = if passed == 0 { sum } else { sum.builder().concat(&[sum, word.lower(passed)]) };
        Self { low: lower.low, word }
    }
}

/// The pieces of a word, the lowest first.
fn pieces(word: Wire<'_>, bits: u32) -> Vec<Wire<'_>> {
    let lows = (0..word.width()).step_by(bits as usize);
    lows.map(|low| word.bits((low + bits).min(word.width()) - 1, low)).collect()
}

fn product_of_two<'m>(m: &'m Builder, a: Wire<'m>, b: Wire<'m>, name: &str) -> Wire<'m> {
    let width = a.width() + b.width();
    if a.width().max(b.width()) <= GATE_BITS {
        return (a * b).named(&format!("product_{name}"));
    }
    let product = (a.extend(BITS) * b.extend(BITS)).named(&format!("product_{name}"));
    if width < 2 * BITS {
        m.unused(&format!("unused_{name}"), &[product.upper(2 * BITS - width)]);
    }
    product.lower(width)
}

/// A row for each bit of a factor.
fn in_gates<'m>(m: &'m Builder, a: Wire<'m>, b: Wire<'m>) -> Wire<'m> {
    let width = a.width() + b.width();
    let row = |bit: u32| {
        let row = a & b.bit(bit).replicate(a.width());
        (if bit == 0 { row } else { m.concat(&[row, m.constant(bit, 0)]) }).extend(width)
    };
    (1..b.width()).fold(row(0), |sum, bit| sum + row(bit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};
    use raypath_hdl::Simulator;

    fn simulator(widths: [u32; 2], bits: u32) -> Simulator {
        let m = Builder::new("product");
        let (a, b) = (m.input("a_i", widths[0]), m.input("b_i", widths[1]));
        m.output("product_o", of_pieces(a, b, bits));
        Simulator::new(&m.finish().expect("a module")).expect("no loop")
    }

    #[test]
    fn sums_of_products_of_pieces_are_products() {
        for (widths, bits) in [([7, 7], 2), ([8, 6], 3), ([6, 8], 5), ([3, 8], 4), ([9, 4], 4)] {
            let mut simulator = simulator(widths, bits);
            for (a, b) in (0..1 << widths[0]).flat_map(|a| (0..1 << widths[1]).map(move |b| (a, b))) {
                assert_eq!(simulator.evaluate([a, b]), [a * b], "{a} * {b}, {widths:?} in {bits}");
            }
        }
        let mut random = ChaCha8Rng::seed_from_u64(1);
        for widths in [[24, 24], [24, 13], [32, 32], [18, 18]] {
            let mut simulator = simulator(widths, BITS);
            for case in 0..3000_u64 {
                let word = |bits: u64, width: u32| {
                    if case.is_multiple_of(8) { !0 >> (64 - width) } else { bits >> (64 - width) }
                };
                let (a, b) =
                    (word(random.random(), widths[0]), word(random.random::<u64>() | bits_of(case), widths[1]));
                assert_eq!(simulator.evaluate([a, b]), [a * b], "{a} * {b}, {widths:?}");
            }
        }
    }

    /// Many ones, now and then.
    fn bits_of(case: u64) -> u64 {
        if case.is_multiple_of(3) { 0xffff_f0ff_0f0f_ffff } else { 0 }
    }

    #[test]
    fn a_multiplier_shows_a_product_two_cycles_later() {
        for widths in [[6, 6], [18, 18], [4, 6]] {
            let multiplier = multiplier(widths[0], widths[1]).expect("a module");
            let mut simulator = Simulator::new(&multiplier).expect("no loop");
            let mut random = ChaCha8Rng::seed_from_u64(2);
            let mut expected = vec![0, 0];
            for case in 0..1000 {
                let [a, b] = widths.map(|width| random.random::<u64>() >> (64 - width));
                let product = simulator.evaluate([a, b])[0];
                assert_eq!(product, expected[case], "{widths:?}");
                expected.push(a * b);
                simulator.cycle();
            }
        }
    }
}
