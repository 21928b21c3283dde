//! Verification of raypath by what is not raypath: floating-point units against Berkeley SoftFloat and by proof, and the
//! pipeline's control by proof.
//!
//! Whatever is verified takes a [`Request`] and gives a [`Verdict`].

pub mod bench;
pub mod control;
mod cores;
pub mod equivalence;
mod item;
pub mod operands;
pub mod proof;
mod request;
pub mod testfloat;
pub mod unit_proofs;
pub mod units;
mod verdict;

pub use item::Item;
pub use request::{Level, Request, Shard, ShardError, Step};
pub use verdict::{Error, Verdict};
