//! Elements of vectors in binary32.

use super::wiring::when;
use raypath_hdl::{Builder, Error, Module};
use std::sync::Arc;

/// The module `raypath_search_widen`, combinational: the element of the kind `elements_i`, which is in `word_i`
/// (binary32), `half_i` (binary16) or `byte_i` (a signed integer), in binary32. All conversions are exact.
pub fn widen() -> Result<Arc<Module>, Error> {
    let builder = Builder::new("raypath_search_widen");
    let m = &builder;
    m.doc("An element of a vector in binary32: one of binary32, of binary16, or a signed integer of 8 bits.");
    let elements = m.input("elements_i", 2);
    let (word, half, byte) = (m.input("word_i", 32), m.input("half_i", 16), m.input("byte_i", 8));
    let is_byte = elements.is(2).named("is_byte");

    m.section("A binary16 number that is not subnormal");
    let (exponent, fraction) = (half.bits(14, 10), half.lower(10));
    let wide = m.concat(&[m.constant(3, 0), exponent]) + m.constant(8, 112);
    let wide = exponent.all().mux(m.constant(8, 255), wide).named("exponent_of_half");

    m.section("An integer, which is the fraction of a subnormal number too");
    let sign = byte.top();
    let magnitude = (byte ^ sign.replicate(8)) + sign.extend(8);
    let integer = is_byte.mux(magnitude.extend(10), fraction).named("digits");
    let mut shifted = integer;
    let mut zeros = Vec::new();
    for step in [8, 4, 2, 1] {
        let is_empty = (!shifted.upper(step.min(9)).any()).named(&format!("is_empty_{step}"));
        shifted = is_empty.mux(shifted.shift_left(m.constant(4, step.into())), shifted);
        zeros.push(is_empty);
    }
    let shifted = shifted.named("shifted");
    let zeros = m.concat(&zeros).named("leading_zeros");
    let above = is_byte.mux(m.constant(8, 127 + 9), m.constant(8, 103 + 9));
    let exponent_of_integer = when(shifted.top(), above - zeros.extend(8)).named("exponent_of_integer");

    let is_integer = (is_byte | !exponent.any()).named("is_integer");
    let narrow = m.concat(&[
        is_byte.mux(sign, half.top()),
        is_integer.mux(exponent_of_integer, wide),
        is_integer.mux(shifted.lower(9), fraction.upper(9)),
        !is_integer & fraction.bit(0),
        m.constant(13, 0),
    ]);
    m.output("number_o", elements.any().mux(narrow, word));
    builder.finish()
}
