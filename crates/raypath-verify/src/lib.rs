//! Verification of raypath: claims about the datapath, each checked against an oracle.
//!
//! An [`Item`] states a claim, names its oracle, and runs the check: it takes a [`Request`] and returns a [`Verdict`].
//! [`ITEMS`] are all items; `docs/development/verification.md` has their results.
//!
//! [`units`] checks the floating-point units against other implementations and by proof, and [`control`] proves the
//! pipeline's control. [`geometry`] compares the operations with exact arithmetic, [`models`] the models with an
//! [`oracle`], and [`campaign`] the netlist with the models, under random [`stimuli`] whose [`coverage`] is counted.
//! [`mutation`] measures how many faults the regression tests find, and [`parsers`] runs damaged files through every
//! parser. [`sat`] and [`equivalence`] are the solvers behind the proofs. [`record`] writes results to files.

pub mod campaign;
pub mod control;
pub mod coverage;
pub mod equivalence;
mod error;
mod files;
pub mod geometry;
pub mod layout;
pub mod models;
pub mod mutation;
pub mod oracle;
pub mod parsers;
pub mod record;
mod request;
pub mod sat;
pub mod stimuli;
pub mod units;
mod verdict;

pub use error::Error;
pub use request::{Level, Progress, Request, Shard, ShardError};
pub use verdict::{Item, Verdict};

use units::proofs;

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
