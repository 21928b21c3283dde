//! Floating-point units in the recoded format, as netlists, for any [`Format`] that the format fits.
//!
//! A recoded number has a sign, an exponent of one bit more than IEEE 754 gives it, and a fraction. The top three bits
//! of the exponent say zero (000), infinity (110) or NaN (111); every other number is normalised, so that no unit has
//! a subnormal case. All units are combinational, round to nearest even and write canonical results; they accept a zero
//! and an infinity with any lower exponent bits and any fraction, and a NaN with any sign and payload.
//!
//! ```
//! use raypath_float::{Format, add};
//! use raypath_hdl::Simulator;
//!
//! let format = Format::BINARY32;
//! let mut simulator = Simulator::new(&add(format)?)?;
//! let (a, b, sum) = (simulator.input("a_i")?, simulator.input("b_i")?, simulator.output("sum_o")?);
//! simulator.set(a, format.encode(1.5_f32.to_bits().into()));
//! simulator.set(b, format.encode(2.25_f32.to_bits().into()));
//! simulator.settle();
//! assert_eq!(format.decode(simulator.get(sum)), 3.75_f32.to_bits().into());
//! # Ok::<(), raypath_hdl::Error>(())
//! ```

mod add;
mod align;
mod booth;
mod compare;
mod compress;
mod decode;
mod encode;
pub mod flags;
mod lookahead;
mod mul;
mod normalise;
mod number;
mod parts;
mod recoded;

pub use add::{add, add_parts, add_parts_with_flags};
pub use compare::compare;
pub use decode::decode;
pub use encode::encode;
pub use mul::{mul, mul_parts, mul_parts_with_flags};
pub use number::number;
pub use raypath_format::{Format, FormatError};
