//! Verification of raypath: claims about the datapath, each checked against an oracle.
//!
//! An [`Item`] states a claim, names its oracle, and runs the check: it takes a [`Request`] and returns a [`Verdict`].
//! [`units`] checks the floating-point units against other implementations and by proof, [`control`] proves the
//! pipeline's control. [`sat`] and [`equivalence`] are the solvers behind the proofs. [`record`] keeps results in files.

pub mod control;
pub mod equivalence;
mod error;
#[doc(hidden)]
pub mod pool;
pub mod record;
mod request;
pub mod sat;
pub mod units;
mod verdict;

pub use error::Error;
pub use request::{Level, Progress, Request, Shard, ShardError};
pub use verdict::{Item, Verdict};
