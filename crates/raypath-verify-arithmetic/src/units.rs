//! The floating-point units: campaigns of operands on their netlists, against independent implementations, and proofs
//! that they compute IEEE 754's operations.

pub mod bench;
pub mod operands;
pub mod proofs;
mod softfloat;
mod testfloat;

pub use softfloat::testfloat;
