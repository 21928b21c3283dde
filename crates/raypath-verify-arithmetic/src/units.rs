//! The floating-point units: campaigns of operands on their netlists, against independent implementations, and proofs
//! that they compute IEEE 754's operations.

mod aimed;
mod answers;
pub mod bench;
mod campaign;
mod conversions;
mod coverage;
mod division;
mod exceptions;
pub mod operands;
pub mod proofs;
mod small_formats;
mod softfloat;
mod testfloat;

pub use conversions::conversions;
pub use division::{Divider, Dividers, division};
pub use small_formats::{oracle, small_formats};
pub use softfloat::testfloat;
