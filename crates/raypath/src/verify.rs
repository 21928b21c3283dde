//! All that can be verified, item by item: what is claimed, by what it is judged, and how it is run.
//!
//! `docs/verification.md` has the same items with their results.

pub mod campaign;
pub mod coverage;
mod files;
mod geometry;
pub mod layout;
pub mod models;
pub mod oracle;
mod parallel;
pub mod parsers;
pub mod shrink;
pub mod stimuli;

pub use raypath_verify::{Error, Level, Request, Shard, ShardError, Step, Verdict};

/// A claim that can be verified.
pub struct Item {
    /// What it is called on the command line.
    pub name: &'static str,
    /// What is claimed.
    pub claim: &'static str,
    /// By what it is judged: something that shares no code with what is verified.
    pub oracle: &'static str,
    /// Verifies it.
    pub run: fn(&mut Request<'_>) -> Result<Verdict, Error>,
}

/// All items, in the order of `docs/verification.md`.
pub const ITEMS: &[Item] = &[
    Item {
        name: "testfloat",
        claim: "the units add, subtract, multiply and compare binary32 as IEEE 754 says, whole and in parts",
        oracle: "Berkeley SoftFloat, on the cases of Berkeley TestFloat",
        run: raypath_verify::units::testfloat,
    },
    Item {
        name: "conversions",
        claim: "recoding loses no number of binary32, keeps their order and follows its table; all words that mean nothing \
                but zero, infinity or NaN are decoded so",
        oracle: "the host's conversion to binary64, and the table of docs/recoded.md",
        run: raypath_verify::units::conversions,
    },
    Item {
        name: "small-formats",
        claim: "the units of small formats answer every pair of operands as IEEE 754 says, whole and in parts",
        oracle: "LLVM's soft float, in the crate rustc_apfloat",
        run: raypath_verify::units::small_formats,
    },
    geometry::WATERTIGHT,
    geometry::BOXES,
    geometry::TRIANGLE_DISTANCE,
    geometry::SUMS,
    campaign::ITEM,
    models::ITEM,
    Item {
        name: "parsers",
        claim: "no file makes raypath panic, hang, or fill the memory",
        oracle: "the bounds that docs/transactions.md, docs/configurations.md and docs/ppa.md state; what was read means the \
                 same when it is written and read again",
        run: parsers::run,
    },
];
