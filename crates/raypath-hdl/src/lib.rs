//! Structural netlists: building, printing and simulation.
//!
//! A [`Builder`] builds a [`Module`], [`verilog`] prints it as SystemVerilog, and [`Simulator`] executes it. Signals
//! are unsigned words of 1 to 64 bits.
//!
//! ```
//! use raypath_hdl::{Builder, Simulator};
//!
//! let m = Builder::new("counter");
//! let step = m.input("step_i", 8);
//! let count = m.register("count_q", 8).reset_to(0);
//! count.next(count.wire() + step);
//! m.output("count_o", count.wire());
//! let counter = m.finish()?;
//!
//! let mut simulator = Simulator::new(&counter)?;
//! let (step, count) = (simulator.input("step_i")?, simulator.output("count_o")?);
//! simulator.set(step, 3);
//! simulator.cycle();
//! simulator.cycle();
//! assert_eq!(simulator.get(count), 3); // the output in the second cycle, before its clock edge
//! # Ok::<(), raypath_hdl::Error>(())
//! ```

#![cfg_attr(not(feature = "simulator"), allow(dead_code))] // what only a simulation reads

mod builder;
mod depth;
mod divide;
mod error;
mod expand;
mod expose;
mod flatten;
mod formula;
mod graph;
#[cfg(feature = "simulator")]
mod jit;
#[cfg(not(feature = "simulator"))]
mod no_jit;
#[cfg(not(feature = "simulator"))]
use no_jit as jit;
mod multipliers;
pub mod mutate;
mod names;
mod netlist;
mod ram;
mod simulator;
pub mod text;
pub mod verilog;
#[cfg(feature = "wave")]
pub mod wave;

pub use builder::memory::Memory;
pub use builder::{Builder, Forward, Register, Wire};
pub use depth::{Technology, longest_path};
pub use divide::divide;
pub use error::Error;
pub use expand::{MAX_EXPANDED_WORDS, expand_memories};
pub use expose::{expose_memories, expose_registers, with_enables};
pub use flatten::{combinational_inputs, depends_combinationally, influences};
pub use formula::Formula;
pub use multipliers::{WithMultipliers, with_multipliers};
pub use names::problem as name_problem;
pub use netlist::{
    Arm, Column, Driver, Instance, Item, Label, MemoryInfo, Module, Port, RegisterInfo, Signal, SignalId,
};
pub use simulator::{InputPort, OutputPort, Probe, Simulator};
