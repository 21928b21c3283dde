//! Verification of raypath: claims about the datapath, each checked against an oracle.
//!
//! An [`Item`] states a claim, names its oracle, and runs the check: it takes a [`Request`] and returns a [`Verdict`].
//! [`ITEMS`] are all items; `docs/development/verification.md` has their results.
//!
//! [`units`] checks the floating-point units against other implementations and by proof. [`control`] proves the
//! pipeline's control, and `dataflow` that it computes its operations. `geometry` compares the operations with exact
//! arithmetic, [`models`] the models with an [`oracle`], and [`campaign`] the netlist with the models, under random
//! [`stimuli`] whose [`coverage`] is counted.
//! [`mutation`] measures how many faults the regression tests find, and [`parsers`] runs damaged files through every
//! parser. [`unit`](mod@unit) has the proofs and the campaign of the traversal unit. [`sat`] and [`equivalence`] are
//! the solvers behind the proofs; the item `gates` proves units after synthesis with them. [`record`] writes results to
//! files.

pub mod campaign;
pub mod control;
pub mod coverage;
mod dataflow;
pub mod equivalence;
mod error;
mod files;
mod gates;
mod geometry;
mod items;
pub mod layout;
pub mod models;
pub mod mutation;
pub mod operation_mutation;
pub mod oracle;
pub mod parsers;
pub mod record;
mod request;
mod reset;
pub mod sat;
mod score;
pub mod stimuli;
pub mod subjects;
mod text_coverage;
pub mod unit;
pub mod units;

pub use error::Error;
pub use items::{ITEMS, Item};
pub use request::{Level, Progress, Request, Shard, ShardError, Verdict};
