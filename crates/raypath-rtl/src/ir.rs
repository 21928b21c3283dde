//! The intermediate representation: each operation as a graph of values.

pub mod graph;
pub mod liveness;
pub mod position;
pub mod recorder;
pub mod units;
pub mod widths;
