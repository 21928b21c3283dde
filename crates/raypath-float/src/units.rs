//! Floating-point units as netlists.

mod add;
mod align;
mod booth;
mod compare;
mod compress;
mod constants;
mod decode;
mod encode;
pub mod flags;
mod lookahead;
mod mul;
mod normalise;
mod number;
mod parts;
mod recoded;

pub use add::{add, add_parts};
pub use compare::compare;
pub use decode::decode;
pub use encode::encode;
pub use mul::{mul, mul_parts};
pub use number::number;
