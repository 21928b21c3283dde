//! Folding: a job every few cycles, and units that compute several values of a stage in turn.
//!
//! With an interval of k, jobs are at least k positions apart. A job is at position 0 in the cycle after its
//! acceptance, and one position further in each cycle in which it moves. A stage has a first position and at most k
//! positions, its rounds. A unit computes another value in each round. A register holds values at positions less than k
//! apart, so that two jobs never need it at once. A stage begins before the stage before it has ended if its operands
//! are there: with four boxes and k = 4, each stage works on one box after another, and the registers hold one box.

mod groups;
mod lives;
mod rounds;
mod search;

pub use lives::{Life, Rounds};
pub use search::{MAX_ELASTIC_POSITIONS, MAX_POSITIONS, plan};
