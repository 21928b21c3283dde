//! Floating-point units as netlists.

mod add;
mod align;
mod booth;
mod compare;
mod compress;
mod constants;
mod decode;
mod div_sqrt;
mod encode;
pub mod flags;
mod iterative;
mod lookahead;
mod mul;
mod mul_narrow;
mod narrow;
mod normalise;
mod number;
mod partial;
mod parts;
mod pipeline;
mod recoded;
mod recurrence;
mod round;
mod sum;

pub use add::{add, add_to_divide};
pub use compare::{compare, compare_narrow};
pub use decode::{decode, decode_narrow};
pub use div_sqrt::{div, sqrt};
pub use encode::encode;
pub use mul::{Product, mul, mul_by_short, mul_to_divide, mul_with_residue};
pub use mul_narrow::mul_narrow;
pub use narrow::{Narrow, narrow};
pub use number::number;
pub use partial::multiplier;
pub use recurrence::DivSqrt;
pub use sum::sum;
