//! Exceptions of IEEE 754, as the units report them.
//!
//! Bits of a unit's output `flags_o`. A division by zero is not among them: there is no division. What is tiny is so
//! *before* rounding, as IEEE 754 allows, and raises underflow only if the result is inexact too. No NaN signals.

use raypath_hdl::{Builder, Wire};

/// How many there are.
pub const COUNT: u32 = 4;
/// The result is rounded: the lowest bit.
pub const INEXACT: u64 = 1;
/// The exact result is below the normal range, and rounded.
pub const UNDERFLOW: u64 = 2;
/// The rounded result is beyond the largest number.
pub const OVERFLOW: u64 = 4;
/// Infinity minus infinity, or zero times infinity: the highest bit.
pub const INVALID: u64 = 8;

/// The output `flags_o`, highest flag first; what a unit never raises is 0.
pub(crate) fn output<'m>(m: &'m Builder, flags: [Option<Wire<'m>>; COUNT as usize]) {
    let bits = flags.map(|flag| flag.unwrap_or_else(|| m.constant(1, 0)));
    m.output("flags_o", m.concat(&bits));
}
