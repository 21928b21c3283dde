//! External programs: how they are found, run and stopped, and how their results are cached.
//!
//! [`Yosys`] synthesises, [`OpenSta`] finds the slowest paths, [`Nextpnr`] places and routes, [`Abc`] and
//! [`SmtSolver`] prove. [`Verilated`] is SystemVerilog compiled by Verilator, an implementation of the language that is
//! independent of `raypath-hdl`'s simulator, so that the two can be compared cycle by cycle. [`Sources::lint`] runs the
//! linters.
//!
//! Every function reports a missing program, a failure or an unexpected result as a [`ToolError`].
//!
//! ```no_run
//! use raypath_hdl::Builder;
//! use raypath_tools::{Sources, Verilated};
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
//! # Ok::<(), raypath_tools::ToolError>(())
//! ```

#[cfg(feature = "cache")]
mod abc;
#[cfg(feature = "cache")]
mod cache;
mod error;
mod files;
mod grouped;
mod input;
mod lint;
mod nextpnr;
mod opensta;
mod program;
mod smt;
mod sources;
mod verilator;
mod verilator_coverage;
mod verilator_main;
mod verilator_stream;
#[cfg(feature = "cache")]
mod versions;
mod yosys;

#[cfg(feature = "cache")]
pub use abc::Abc;
#[cfg(feature = "cache")]
pub use cache::{Cache, Key, MAX_RESULT_BYTES, decode, digest};
pub use error::ToolError;
pub use files::{read, temporary_folder, write};
pub use grouped::grouped;
pub use input::{MemoryLimit, plain_or_gzip, read_within, text};
pub use lint::{lint_icarus, lint_slang, lint_verilator, lint_yosys};
pub use nextpnr::Nextpnr;
pub use opensta::OpenSta;
pub use program::Program;
pub use smt::SmtSolver;
pub use sources::Sources;
pub use verilator::{Options, Verilated, VerilatedStream};
pub use verilator_coverage::{CoverageKind, CoveragePoint};
#[cfg(feature = "cache")]
pub use versions::versions;
pub use yosys::{Yosys, YosysKind};
