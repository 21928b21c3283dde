//! All that can be verified, item by item: what is claimed, by what it is judged, and how it is run.
//!
//! `docs/verification.md` has the same items with their results.

mod mutation;

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
    name: "mutation",
    claim: "the everyday tests kill at least 99 % of the faults in the netlist that are not proven equivalent",
    oracle: "the checks that the everyday tests make: units against the host's f32, the datapath against its models",
    run: mutation::run,
}];
