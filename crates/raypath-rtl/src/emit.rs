//! Emission: the netlist of a plan, and the assertions about it.

pub mod boundary;
mod control;
mod elastic;
mod folded;
mod input;
pub mod interface;
mod isolation;
pub mod library;
mod output;
mod positions;
pub mod properties;
pub mod stage;
pub mod top;
mod values;
