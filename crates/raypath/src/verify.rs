//! All that can be verified, item by item: what is claimed, by what it is judged, and how it is run.
//!
//! `docs/verification.md` has the same items with their results.

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
pub const ITEMS: &[Item] = &[Item {
    name: "control",
    claim: "no job is lost, repeated or reordered, a stalled output stays, an accumulator acts once for each beat",
    oracle: "proofs by Yosys and ABC of the emitted SystemVerilog with its assertions, units free",
    run: raypath_verify::control::control,
}];
