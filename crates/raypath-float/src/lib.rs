//! Floating-point formats ([`format`](mod@format)), and floating-point units as netlists (feature `units`, which is
//! the only part that needs `raypath-hdl`).
//!
//! A recoded number has a sign, an exponent of one bit more than in IEEE 754, and a fraction. The top three bits of the
//! exponent encode zero (000), infinity (110) and NaN (111); every other number is normalised, so units need no case
//! for subnormals. All units round to nearest even and return canonical results. They accept zeros and infinities with
//! any lower exponent bits and any fraction, and NaN with any sign and payload. They are combinational, except the
//! pipelined and iterative forms of [`DivSqrt`].
//!
//! ```
//! use raypath_float::{Format, add};
//! use raypath_hdl::Simulator;
//!
//! let format = Format::BINARY32;
//! let mut simulator = Simulator::new(&add(format, false)?)?;
//! let (a, b, sum) = (simulator.input("a_i")?, simulator.input("b_i")?, simulator.output("sum_o")?);
//! simulator.set(a, format.encode(1.5_f32.to_bits().into()));
//! simulator.set(b, format.encode(2.25_f32.to_bits().into()));
//! simulator.settle();
//! assert_eq!(format.decode(simulator.get(sum)), 3.75_f32.to_bits().into());
//! # Ok::<(), raypath_hdl::Error>(())
//! ```

pub mod format;
#[cfg(feature = "units")]
mod units;

pub use format::{Format, FormatError, ParseFormatError};
#[cfg(feature = "units")]
pub use units::{
    DivSqrt, Narrow, Product, add, add_to_divide, compare, compare_narrow, decode, decode_narrow, div, encode, flags,
    mul, mul_by_short, mul_narrow, mul_to_divide, mul_with_residue, multiplier, narrow, number, sqrt, sum,
};
