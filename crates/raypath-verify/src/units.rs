//! The floating-point units: campaigns of operands on their netlists, against independent implementations, and proofs
//! that they compute IEEE 754's operations.

pub mod bench;
mod campaign;
mod conversions;
pub mod operands;
pub mod proofs;
mod small_formats;
mod softfloat;
mod testfloat;

pub use conversions::{conversions, conversions_of};
pub use small_formats::{oracle, small_formats, small_formats_of};
pub use softfloat::{testfloat, testfloat_of};

use crate::verdict::Item;

/// The sources that the result of each campaign depends on.
const SUBJECT: &[&str] = &["crates/raypath-float/src", "crates/raypath-hdl/src", "crates/raypath-verify/src/units"];

/// Berkeley TestFloat's cases on the units of binary32.
pub const TESTFLOAT: Item = Item {
    name: "testfloat",
    claim: "the units add, subtract, multiply and compare binary32 as IEEE 754 specifies, unsplit and split",
    oracle: "Berkeley SoftFloat, on the cases of Berkeley TestFloat",
    subject: SUBJECT,
    run: testfloat,
};

/// Encoding and decoding of binary32.
pub const CONVERSIONS: Item = Item {
    name: "conversions",
    claim: "recoding loses no number of binary32, keeps their order and follows its table; every word of the classes \
            zero, infinity and NaN is decoded by its class alone",
    oracle: "the host's conversion to binary64, and the table of docs/reference/formats.md",
    subject: SUBJECT,
    run: conversions,
};

/// All pairs of operands of small formats.
pub const SMALL_FORMATS: Item = Item {
    name: "small-formats",
    claim: "the units of small formats give IEEE 754's result for every pair of operands, unsplit and split",
    oracle: "LLVM's soft float, in the crate rustc_apfloat",
    subject: SUBJECT,
    run: small_formats,
};
