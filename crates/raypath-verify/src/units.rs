//! Campaigns: every case through the netlists of the floating-point units, against oracles that share nothing with them.

mod berkeley;
mod conversions;
mod small_formats;
mod softfloat;

pub use conversions::{conversions, conversions_of};
pub use small_formats::{small_formats, small_formats_of};
pub use softfloat::{testfloat, testfloat_of};

use crate::Item;

/// Cases that were made to find faults.
pub const TESTFLOAT: Item = Item {
    name: "testfloat",
    claim: "the units add, subtract, multiply and compare binary32 as IEEE 754 says, whole and in parts",
    oracle: "Berkeley SoftFloat, on the cases of Berkeley TestFloat",
    run: testfloat,
};

/// Encoding and decoding.
pub const CONVERSIONS: Item = Item {
    name: "conversions",
    claim: "recoding loses no number of binary32, keeps their order and follows its table; all words that mean nothing \
            but zero, infinity or NaN are decoded so",
    oracle: "the host's conversion to binary64, and the table of docs/reference/formats.md",
    run: conversions,
};

/// Formats small enough for all pairs.
pub const SMALL_FORMATS: Item = Item {
    name: "small-formats",
    claim: "the units of small formats answer every pair of operands as IEEE 754 says, whole and in parts",
    oracle: "LLVM's soft float, in the crate rustc_apfloat",
    run: small_formats,
};
