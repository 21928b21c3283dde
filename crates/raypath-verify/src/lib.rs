//! Verification of raypath by what is not raypath: floating-point units against Berkeley SoftFloat and by proof, and the
//! pipeline's control by proof.
//!
//! Whatever is verified takes a [`Request`] and gives a [`Verdict`].

mod chain;
pub mod equivalence;
pub mod operands;
pub mod proof;
mod request;
mod verdict;

pub use chain::chain;
pub use request::{Level, Request, Shard, ShardError, Step};
pub use verdict::{Error, Verdict};
