//! The boxes of quantised nodes.

use super::blocks::job_words;
use super::connect::hold;
use super::parameters::UnitParameters;
use super::queue::bits;
use crate::blocks::VERTEX_WORDS;
use crate::blocks::quantised::{BOUNDS, Operands, WORDS, operands, place};
use crate::netlist::{Netlist, Value};
use raypath_float::{Format, add, decode, encode};
use raypath_hdl::{Builder, Error, Module, Wire};
use raypath_ops::{Bit, Flags, Word};
use std::sync::Arc;

/// The cycles that a block is in the decoder.
pub const LATENCY: u32 = 2;

/// The module `raypath_unit_decoder`, between the memory of the blocks and the datapath.
///
/// A block, `word_…_i`, of which the children `exists_…_i` exist, enters with `context_i` where `valid_i` and `ready_o`
/// are 1. It is at the outputs two cycles later, with `valid_o` and `context_o`, until `ready_i` is 1: as a node's
/// bounds, `bound_…_o`, and as words of a triangle or of an instance, `word_…_o`. With instances, a block that
/// `is_instance_i` there leaves twice, and `is_last_o` is 1 at the second time and for other blocks. Where `read_o` is 1, the block of `read_context_o` is
/// at the outputs in the next cycle, so that what else is kept for it can be read.
pub fn decoder(UnitParameters { contexts, step, .. }: UnitParameters) -> Result<Arc<Module>, Error> {
    let builder = Builder::new("raypath_unit_decoder");
    let m = &builder;
    m.doc("The boxes of quantised nodes: one addition for each bound. Other blocks pass by.");
    let valid = m.input("valid_i", 1);
    let context = m.input("context_i", bits(contexts));
    let words: Vec<Wire<'_>> = (0..job_words(step).len()).map(|k| m.input(&format!("word_{k}_i"), 32)).collect();
    let exists: [Wire<'_>; 4] = std::array::from_fn(|k| m.input(&format!("exists_{k}_i"), 1));
    let is_instance = step.features.instances.then(|| m.input("is_instance_i", 1));
    let ready = m.input("ready_i", 1);
    let advances = m.forward("advances", 1);
    let advance = advances.wire();

    m.section("The operands: bases and exponents are recoded, fractions are bits of the block");
    let has_operands = m.register("has_operands_q", 1).reset_to(0);
    has_operands.next_when(advance, valid);
    let has_operands = has_operands.wire();
    let operands_context = hold("operands_context_q", advance, context);
    let encoder = encode(Format::BINARY32)?;
    let recoded =
        |name: &str, wire: Wire<'_>| m.instance(&format!("u_encode_{name}"), &encoder, &[("ieee_i", wire)])[0];
    let Operands { base, power, .. } = of_block(m, &words, exists);
    let axes = ["x", "y", "z"];
    let base: [Wire<'_>; 3] = std::array::from_fn(|axis| {
        let name = format!("base_{}", axes[axis]);
        hold(&format!("{name}_q"), advance, recoded(&name, base[axis].value.0))
    });
    let exponent: [Wire<'_>; 3] = std::array::from_fn(|axis| {
        let name = format!("exponent_{}", axes[axis]);
        let power = recoded(&name, power[axis].value.0);
        m.unused(&format!("unused_{name}"), &[power.top(), power.lower(FRACTION)]);
        hold(&format!("{name}_q"), advance, power.bits(FRACTION + EXPONENT - 1, FRACTION))
    });
    let words: Vec<Wire<'_>> =
        words.iter().enumerate().map(|(k, word)| hold(&format!("word_{k}_q"), advance, *word)).collect();
    let exists = std::array::from_fn(|k| hold(&format!("exists_{k}_q"), advance, exists[k]));

    m.section("The sums");
    let has_sums = m.register("has_sums_q", 1).reset_to(0);
    has_sums.next_when(advance, has_operands);
    let has_sums = has_sums.wire();
    let context = hold("context_q", advance, operands_context);
    let Operands { fraction, exists: Flags(exists), .. } = of_block(m, &words, exists);
    let (adder, infinity) = (add(Format::BINARY32)?, m.constant(EXPONENT, INFINITY));
    let sum = |bound: usize| {
        let ((axis, is_max), exists) = (place(bound), exists[bound / 6].value.0);
        let sign = if is_max { !exists } else { m.constant(1, 0) };
        let exponent = exists.mux(exponent[axis], infinity);
        let fraction = [fraction[bound].value.0, m.constant(FRACTION - 8, 0)];
        let addend = m.concat(&[sign, exponent, fraction[0], fraction[1]]);
        let sum = m.instance(&format!("u_add_{bound}"), &adder, &[("a_i", base[axis]), ("b_i", addend)])[0];
        hold(&format!("sum_{bound}_q"), advance, sum)
    };
    let sums: Vec<Wire<'_>> = (0..BOUNDS).map(sum).collect();
    let passes = if is_instance.is_some() { words.len() } else { VERTEX_WORDS };
    let passed = (0..passes).map(|k| hold(&format!("passed_{k}_q"), advance, words[k]));
    let passed: Vec<Wire<'_>> = passed.collect();
    let is_last = is_instance.map(|is_instance| {
        let is_second = m.register("is_second_q", 1).reset_to(0);
        let is_last = (!is_instance | is_second.wire()).named("is_last");
        is_second.next_when(has_sums & ready, !is_last);
        is_last
    });
    let leaves = is_last.map_or(ready, |is_last| ready & is_last);
    advances.drive(!has_sums | leaves);

    m.section("The bounds in IEEE 754's layout");
    let decoder = decode(Format::BINARY32)?;
    let bound = |(k, sum): (usize, &Wire<'_>)| {
        let bound = m.instance(&format!("u_decode_{k}"), &decoder, &[("recoded_i", *sum)])[0];
        m.output(&format!("bound_{k}_o"), bound);
    };
    m.output("ready_o", advance);
    m.output("read_o", (advance & has_operands).named("read"));
    m.output("read_context_o", operands_context);
    m.output("valid_o", has_sums);
    m.output("context_o", context);
    sums.iter().enumerate().for_each(bound);
    passed.iter().enumerate().for_each(|(k, word)| m.output(&format!("word_{k}_o"), *word));
    is_last.into_iter().for_each(|is_last| m.output("is_last_o", is_last));
    builder.finish()
}

fn of_block<'m>(m: &'m Builder, words: &[Wire<'m>], exists: [Wire<'m>; 4]) -> Operands<Netlist<'m>> {
    let c = Netlist(m);
    let words: [Word<Netlist<'m>, 32>; WORDS] = std::array::from_fn(|k| Word::new(c, Value(words[k])));
    operands(c, words, Flags(exists.map(|bit| Bit::new(c, Value(bit)))))
}

/// The bits of a recoded number's fraction and exponent, and the exponent of infinity.
const FRACTION: u32 = 23;
const EXPONENT: u32 = 9;
const INFINITY: u64 = 0b110 << 6;
