//! The boxes of compressed nodes.

use super::blocks::{MATRIX_WORDS, matrix_words};
use super::connect::hold;
use super::parameters::UnitParameters;
use super::queue::bits;
use crate::StepParameters;
use crate::blocks::quantised::{self, BOUNDS, FIRST_BOUND};
use crate::blocks::{BOX_WORDS, NodeKind, VERTEX_WORDS, wide8};
use raypath_float::{Format, add, decode, encode};
use raypath_hdl::{Builder, Error, Module, Wire};
use std::collections::BTreeSet;
use std::sync::Arc;

/// The cycles that a job is in the decoder.
pub const LATENCY: u32 = 2;

/// The module `raypath_unit_decoder`, between the memory of the blocks and the datapath.
///
/// A job, `context_i` with `place_i` and `is_last_i`, enters where `valid_i` and `ready_o` are 1. It is at the outputs
/// two cycles later, with `valid_o`, until `ready_i` is 1: with the bounds of four boxes, `bound_…_o`, and with the
/// words of a triangle or of an instance, `word_…_o`. Where `read_o` is 1, the job of `read_context_o` is at the outputs
/// in the next cycle, so that what is kept for it can be read.
///
/// Its block is `word_…_i`, of which the children `exists_…_i` exist, in the first nine words with the triangle of the
/// job. With eight children, the last job of a block that `is_node_i` has the upper four, the place of both is
/// `window_i`, and the words of a triangle are `triangle_…_i`; a block that `is_instance_i` has them where instances
/// have them.
pub fn decoder(UnitParameters { contexts, step, .. }: UnitParameters) -> Result<Arc<Module>, Error> {
    let builder = Builder::new("raypath_unit_decoder");
    let m = &builder;
    m.doc("The boxes of compressed nodes: one addition for each bound. Other blocks pass by.");
    m.doc(
        "An addend needs no multiplier: its exponent is that of the node, and its fraction the byte of the bound, with",
    );
    m.doc(
        "eight children after its highest bit, which adds to the exponent. Recoded numbers have no subnormals, so that",
    );
    m.doc("any power is an exponent. A child that does not exist has the box from +infinity to -infinity: no ray hits it.");
    let valid = m.input("valid_i", 1);
    let context = m.input("context_i", bits(contexts));
    let mut of_job = step.of_job().map(|(name, width)| (name, m.input(&format!("{name}_i"), width)));
    let of_block = words(step);
    let word = |k: usize| if of_block.contains(&k) { m.input(&format!("word_{k}_i"), 32) } else { m.constant(32, 0) };
    let words: Vec<Wire<'_>> = (0..step.node.block_bytes() as usize / 4).map(word).collect();
    let exists: Vec<Wire<'_>> = (0..step.node.children()).map(|k| m.input(&format!("exists_{k}_i"), 1)).collect();
    let ready = m.input("ready_i", 1);
    let has_sums = m.register("has_sums_q", 1).reset_to(0);
    let advance = (!has_sums.wire() | ready).named("advance");

    m.section("The operands: bases and exponents are recoded, fractions are bits of the block");
    let has_operands = m.register("has_operands_q", 1).reset_to(0);
    has_operands.next_when(advance, valid);
    let operands_context = held(advance, "operands_context", context);
    let encoder = encode(Format::BINARY32)?;
    let recoded =
        |name: &str, wire: Wire<'_>| m.instance(&format!("u_encode_{name}"), &encoder, &[("ieee_i", wire)])[0];
    let axes = ["x", "y", "z"];
    let base: [Wire<'_>; 3] = std::array::from_fn(|axis| {
        let name = format!("base_{}", axes[axis]);
        held(advance, &name, recoded(&name, words[axis]))
    });
    let exponent: [Wire<'_>; 3] = std::array::from_fn(|axis| {
        let name = format!("exponent_{}", axes[axis]);
        let power = m.concat(&[m.constant(1, 0), byte(&words, 12 + axis), m.constant(FRACTION, 0)]);
        let power = recoded(&name, power);
        m.unused(&format!("unused_{name}"), &[power.top(), power.lower(FRACTION)]);
        power.bits(FRACTION + EXPONENT - 1, FRACTION)
    });
    let (addends, passed) = match step.node {
        NodeKind::Wide8 => {
            let triangle: Vec<Wire<'_>> = (0..VERTEX_WORDS).map(|k| m.input(&format!("triangle_{k}_i"), 32)).collect();
            let matrix = |k: usize| words[step.node.matrix_word(k)];
            let passed = match step.features.instances.then(|| m.input("is_instance_i", 1)) {
                None => triangle,
                Some(is_instance) => (0..MATRIX_WORDS)
                    .map(|k| triangle.get(k).map_or(matrix(k), |coordinate| is_instance.mux(matrix(k), *coordinate)))
                    .collect(),
            };
            let (is_node, window) = (m.input("is_node_i", 1), m.input("window_i", 2));
            let is_upper = of_job[1].1;
            of_job[0].1 = is_node.mux(window, of_job[0].1);
            if !step.features.instances {
                m.unused("unused_exponents", &[words[3].upper(8)]);
            }
            let addend = |bound: usize| {
                let (axis, is_max) = quantised::place(bound);
                let child = bound / BOX_WORDS;
                let of = |child: usize| (byte(&words, wide8::bound_byte(axis, is_max.into(), child)), exists[child]);
                let (lower, upper) = (of(child), of(child + 4));
                let q = is_upper.mux(upper.0, lower.0).hint("quantised_bound");
                let exists = is_upper.mux(upper.1, lower.1).hint("child_exists");
                held(advance, &format!("addend_{bound}"), product(q, exponent[axis], exists, is_max))
            };
            ((0..BOUNDS).map(addend).collect(), passed)
        }
        NodeKind::Wide4 | NodeKind::Quantised => {
            let passed = if step.features.instances { MATRIX_WORDS } else { quantised::WORDS };
            (Vec::new(), (0..passed).map(|number| words[step.node.matrix_word(number)]).collect())
        }
    };
    let exponent: [Wire<'_>; 3] = match step.node {
        NodeKind::Wide8 => exponent,
        _ => std::array::from_fn(|axis| held(advance, &format!("exponent_{}", axes[axis]), exponent[axis])),
    };
    let words: Vec<Wire<'_>> =
        (0..).zip(passed).map(|(k, word): (u32, _)| held(advance, &format!("word_{k}"), word)).collect();
    for (name, wire) in &mut of_job {
        *wire = held(advance, &format!("operands_{name}"), *wire);
    }

    m.section("The sums");
    has_sums.next_when(advance, has_operands.wire());
    let adder = add(Format::BINARY32, false)?;
    let addends = if addends.is_empty() {
        let exists: Vec<Wire<'_>> =
            (0..).zip(exists).map(|(k, bit): (u32, _)| held(advance, &format!("exists_{k}"), bit)).collect();
        let addend = |bound: usize| {
            let (axis, is_max) = quantised::place(bound);
            let fraction = m.concat(&[byte(&words, FIRST_BOUND + bound), m.constant(FRACTION - 8, 0)]);
            number_or_missing(exponent[axis], fraction, exists[bound / BOX_WORDS], is_max)
        };
        (0..BOUNDS).map(addend).collect()
    } else {
        addends
    };
    let sum = |(bound, addend): (usize, Wire<'_>)| {
        let base = base[quantised::place(bound).0];
        held(
            advance,
            &format!("sum_{bound}"),
            m.instance(&format!("u_add_{bound}"), &adder, &[("a_i", base), ("b_i", addend)])[0],
        )
    };
    let sums: Vec<Wire<'_>> = addends.into_iter().enumerate().map(sum).collect();
    let passes = if step.features.instances { MATRIX_WORDS } else { VERTEX_WORDS };
    let passed: Vec<Wire<'_>> = (0..passes).map(|k| held(advance, &format!("passed_{k}"), words[k])).collect();

    m.section("The bounds in IEEE 754's layout");
    let decoder = decode(Format::BINARY32)?;
    let bound = |(k, sum): (usize, &Wire<'_>)| {
        let bound = m.instance(&format!("u_decode_{k}"), &decoder, &[("recoded_i", *sum)])[0];
        m.output(&format!("bound_{k}_o"), bound);
    };
    m.output("ready_o", advance);
    m.output("read_o", (advance & has_operands.wire()).named("read"));
    m.output("read_context_o", operands_context);
    m.output("valid_o", has_sums.wire());
    m.output("context_o", held(advance, "context", operands_context));
    sums.iter().enumerate().for_each(bound);
    passed.iter().enumerate().for_each(|(k, word)| m.output(&format!("word_{k}_o"), *word));
    for (name, wire) in of_job {
        m.output(&format!("{name}_o"), held(advance, name, wire));
    }
    builder.finish()
}

/// The words of a block that the decoder reads, besides children: those with bases, exponents, bounds and a matrix.
pub fn words(step: StepParameters) -> BTreeSet<usize> {
    let first = wide8::bound_byte(0, 0, 0) / 4;
    let bounds = if step.node == NodeKind::Wide8 { first..first + 2 * BOX_WORDS } else { 0..0 };
    (0..step.node.child_word()).chain(bounds).chain(matrix_words(step)).collect()
}

/// A register of a stage.
fn held<'m>(advance: Wire<'m>, name: &str, wire: Wire<'m>) -> Wire<'m> {
    hold(&format!("{name}_q"), advance, wire)
}

fn byte<'m>(words: &[Wire<'m>], place: usize) -> Wire<'m> {
    let low = 8 * (place % 4) as u32;
    words[place / 4].bits(low + 7, low)
}

/// The addend of a bound of eight children: q times the power with this exponent. Exponents of the recoded format go on
/// into those of infinity, and those of 0 stay so.
fn product<'m>(q: Wire<'m>, exponent: Wire<'m>, exists: Wire<'m>, is_max: bool) -> Wire<'m> {
    let m = q.builder();
    let highest = (1..8)
        .fold(m.constant(3, 0), |lower, bit| q.bit(bit).mux(m.constant(3, bit.into()), lower).hint("highest_bit"));
    let scaled = exponent + m.concat(&[m.constant(EXPONENT - 3, 0), highest]);
    let exponent = q.any().mux(scaled, m.constant(EXPONENT, 0)).hint("scaled_exponent");
    let fraction = q.lower(7).shift_left(!highest);
    number_or_missing(exponent, m.concat(&[fraction, m.constant(FRACTION - 7, 0)]), exists, is_max)
}

/// A number that is not negative, or the infinity with which no ray hits the box.
fn number_or_missing<'m>(exponent: Wire<'m>, fraction: Wire<'m>, exists: Wire<'m>, is_max: bool) -> Wire<'m> {
    let m = exponent.builder();
    let sign = if is_max { !exists } else { m.constant(1, 0) };
    let exponent = exists.mux(exponent, m.constant(EXPONENT, INFINITY)).hint("exponent_or_infinity");
    m.concat(&[sign, exponent, fraction])
}

/// The bits of a recoded number's fraction and exponent, and the exponent of infinity.
const FRACTION: u32 = 23;
const EXPONENT: u32 = 9;
const INFINITY: u64 = 0b110 << 6;
