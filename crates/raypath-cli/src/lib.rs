//! The command line of raypath, as a library: [`main`](main()) is the whole `raypath` program.
//!
//! The commands that every build has are `generate`, `configs`, `operations` and `ray`. The feature `full` adds those
//! that need more libraries: `render`, `search`, `replay`, `wave`, `accuracy`, `bench`, `ppa`, `fpga` and `explore`.
//! The feature `verify` adds `verify` to them. The feature `workbench` has the command line for a crate with an
//! operation of its own (the module `workbench`), which `examples/within_radius` uses.

#[cfg(feature = "full")]
pub mod accuracy;
mod build;
mod commands;
mod cost;
mod error;
#[cfg(feature = "workbench")]
mod measure;
mod oracles;
pub mod prelude;
mod progress;
#[cfg(feature = "workbench")]
pub mod workbench;

pub use build::Build;
pub use commands::{CommandLine, main, run};
pub use cost::{Cost, Figures};
pub use error::CliError;
pub use raypath_ops as ops;
pub use raypath_oracle as oracle;
pub use raypath_rtl as rtl;
pub use raypath_sim as sim;

#[cfg(feature = "full")]
use commands::configuration::ConfigArguments;
use commands::configuration::DatapathArguments;
#[cfg(feature = "full")]
use commands::numbers::number;
use commands::numbers::whole;
use oracles::ask_oracles;
#[cfg(feature = "workbench")]
use oracles::require_right;
use progress::Progress;
#[cfg(feature = "workbench")]
use progress::{Stopped, is_stopped};
