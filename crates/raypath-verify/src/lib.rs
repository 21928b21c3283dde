//! Verification of raypath by what is not raypath: floating-point units against Berkeley SoftFloat and by proof, and the
//! pipeline's control by proof.
//!
//! Whatever is verified takes a [`Request`] and gives a [`Verdict`].

pub mod control;
mod request;
mod verdict;

pub use request::{Level, Request, Shard, ShardError, Step};
pub use verdict::{Error, Verdict};
