//! All that can be verified, item by item: what is claimed, by what it is judged, and how it is run.
//!
//! `docs/development/verification.md` has the same items with their results.

pub mod campaign;
pub mod coverage;
mod files;
mod geometry;
pub mod layout;
pub mod models;
pub mod mutation;
pub mod oracle;
pub mod parsers;
pub mod shrink;
pub mod stimuli;

pub use raypath_verify::{Error, Item, Level, Progress, Request, Shard, ShardError, Verdict, record};

use raypath_verify::units::proofs;
use raypath_verify::{control, units};

/// All items, in the order of `docs/development/verification.md`.
pub const ITEMS: &[Item] = &[
    units::TESTFLOAT,
    units::CONVERSIONS,
    units::SMALL_FORMATS,
    proofs::UNIT_PROOFS,
    proofs::ADDER_PROOF,
    proofs::MULTIPLIER_PROOF,
    control::CONTROL,
    geometry::WATERTIGHT,
    geometry::BOXES,
    geometry::TRIANGLE_DISTANCE,
    geometry::SUMS,
    models::ITEM,
    campaign::ITEM,
    mutation::ITEM,
    parsers::ITEM,
];
