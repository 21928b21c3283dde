//! Exceptions of IEEE 754, as the units report them.
//!
//! The constants are bits of a unit's output `flags_o`, which adders and multipliers have: dividers report nothing, so
//! there is no flag for a division by zero. Tininess is detected *before* rounding, as IEEE 754 allows, and raises
//! underflow only if the result is also inexact. No NaN is signalling.

use crate::Format;
use raypath_hdl::{Builder, Wire};

/// The number of flags.
pub const COUNT: u32 = 4;
/// The result is rounded: the lowest bit.
pub const INEXACT: u64 = 1;
/// The exact result is below the normal range, and the result is rounded.
pub const UNDERFLOW: u64 = 2;
/// The rounded result is beyond the largest number.
pub const OVERFLOW: u64 = 4;
/// Infinity minus infinity, or zero times infinity: the highest bit.
pub const INVALID: u64 = 8;

/// Adds the output `flags_o`, highest flag first. A flag that a unit never raises is 0.
pub(crate) fn output<'m>(m: &'m Builder, flags: [Option<Wire<'m>>; COUNT as usize]) {
    let bits = flags.map(|flag| flag.unwrap_or_else(|| m.constant(1, 0)));
    m.output("flags_o", m.concat(&bits));
}

/// Begins the module of a unit that rounds `result`: `raypath_fp_<operation>_<format>`, or with flags
/// `raypath_fp_<operation>_flags_<format>`.
pub(crate) fn unit(operation: &str, result: &str, format: Format, with_flags: bool) -> Builder {
    let (in_name, in_doc) = if with_flags { ("_flags", ", and its exceptions") } else { ("", "") };
    let m = Builder::new(&format!("raypath_fp_{operation}{in_name}_{format}"));
    m.doc(format!("{result}, rounded to nearest even{in_doc}."));
    m
}
