//! Handshake control: skid buffers, or credits and a FIFO at the exit.
//!
//! The netlist has the control of a buffer in a module of its own and the data registers in each stage. The text holds
//! both in one module, whose width is a parameter. Both are built by the same functions.

mod buffer;
mod credit;
mod exit;
mod gate;
mod plain;
mod rounds;
mod skid;

pub use credit::{Spacing, credit};
pub use exit::Exit;
pub use gate::Gate;
pub use plain::Plain;
pub use rounds::{Rounds, words};
pub use skid::Skid;
