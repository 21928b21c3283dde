//! What all verification shares: items with their requests and verdicts, and the solvers behind the proofs.
//!
//! An [`Item`] states a claim, names its oracle, and runs the check: it takes a [`Request`] and returns a [`Verdict`].
//! The crates `raypath-verify-arithmetic`, `raypath-verify-datapath`, `raypath-verify-traversal` and
//! `raypath-verify-mutation` have the items. [`sat`] proves that two functions are equal, [`equivalence`] that two
//! modules are, and [`safety`] that assertions hold in all cycles. [`proofs`] keeps their results. A [`campaign`] runs
//! random cases on all cores.

pub mod campaign;
pub mod equivalence;
mod error;
pub mod files;
mod item;
pub mod proofs;
mod request;
pub mod safety;
pub mod sat;

pub use error::Error;
pub use item::Item;
pub use request::{Level, Progress, Request, Shard, ShardError, Verdict};
