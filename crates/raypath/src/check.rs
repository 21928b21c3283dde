//! Netlist and models side by side.

mod canonical;
mod everyday;

pub use everyday::{Everyday, Failed};
pub use raypath_lab::check::{Comparison, Difference, SideBySide, Timing, lockstep, timing};
