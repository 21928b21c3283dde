//! A traversal unit around the datapath: a ray goes in, the closest or any hit comes out.
//!
//! [`step()`] says what happens to a ray when an answer arrives: one function, generic over its circuit. [`Unit`] is
//! the functional model, which steps a ray until it ends. [`blocks`] is the layout of a scene in memory.

pub mod blocks;
mod hardware;
mod model;
mod netlist;
pub mod state;
mod step;
mod words;

pub use hardware::step_module;
pub use model::{Hit, Memory, MemoryError, RayRequest, Reply, Unit};
pub use netlist::{Inputs, Netlist, Outputs, Value};
pub use step::{StepParameters, VISIT_LIMIT, step};
pub use words::{LEVELS, Levels, WordCircuit, WordMethods};
