//! Runs emitted SystemVerilog in Verilator, and past three tools that must have nothing to say about it.
//!
//! The simulator of `raypath-hdl` executes the netlist; what is emitted is text. Here the text is compiled by somebody
//! else's compiler, so that the two can be compared cycle by cycle.
//!
//! ```no_run
//! use raypath_cosim::{Sources, Verilated};
//! use raypath_hdl::Builder;
//!
//! let m = Builder::new("counter");
//! let step = m.input("step_i", 8);
//! let count = m.register("count_q", 8).reset_to(0);
//! count.next(count.wire() + step);
//! m.output("count_o", count.wire());
//! let top = m.finish()?;
//!
//! let folder = std::path::Path::new("build");
//! Sources::write(&top, folder)?.lint()?;
//! let verilated = Verilated::build(&top, folder)?;
//! let frames = (0..1000).map(|cycle| vec![1, cycle]); // rst_ni, then the inputs in the order of declaration
//! verilated.run(frames, |cycle, outputs| println!("{cycle}: {outputs:?}"))?;
//! # Ok::<(), raypath_cosim::CosimError>(())
//! ```

mod error;
mod harness;
mod lint;
mod sources;
mod tool;
mod verilated;

pub use error::CosimError;
pub use lint::{lint_slang, lint_verilator, lint_yosys};
pub use sources::Sources;
pub use verilated::{Options, Verilated};
