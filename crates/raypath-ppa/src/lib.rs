//! Area and timing of a netlist, by open tools: Yosys chooses the gates, OpenSTA times them.
//!
//! A [`Design`] is a netlist whose top module consists of stages. A [`Bench`] holds a cell library, the tools and a
//! cache, and measures designs into [`Report`]s. `docs/user/area-and-timing.md` says what the figures include.
//!
//! ```no_run
//! use raypath_ppa::{Bench, DEFAULT_LIBRARY, Design, Library};
//! use raypath_tools::{OpenSta, Yosys};
//! use std::path::Path;
//!
//! # fn top() -> std::sync::Arc<raypath_hdl::Module> { unimplemented!() }
//! let bench = Bench {
//!     library: Library::read(Path::new(DEFAULT_LIBRARY))?,
//!     yosys: Yosys::find(None)?,
//!     sta: OpenSta::find()?,
//!     period: 12.0,
//!     unit_period: None,
//!     jobs: 4,
//!     cache: "build/ppa-cache".into(),
//! };
//! let reports = bench.measure(&[Design::new("mine", &top())], |_| true)?;
//! println!("{} flip-flops, {} MHz", reports[0].flip_flops, reports[0].clock_mhz);
//! # Ok::<(), raypath_ppa::Error>(())
//! ```

mod activity;
mod attribution;
mod baseline;
mod bench;
pub mod charts;
mod clock_gates;
mod design;
mod energy;
mod equivalents;
mod error;
pub mod explore;
mod function;
mod gates;
mod liberty;
mod library;
mod logic;
mod names;
mod netlist;
#[doc(hidden)]
pub mod parsers;
mod power;
mod recipe;
mod report;
mod saif;
mod structural;
mod synthesis;
pub mod tables;
mod timing;

pub use activity::{Check, Frame, STREAMS, Workload};
pub use baseline::{Baseline, BaselineArea, BaselineStage};
pub use bench::Bench;
pub use design::Design;
pub use equivalents::SynthesisedUnit;
pub use error::Error;
pub use library::{Cell, DEFAULT_LIBRARY, Library};
pub use power::PowerResults;
pub use raypath_work::pool::Progress;
pub use report::{
    Area, DesignPoint, Exploration, Path, Power, Report, Setting, Slowest, Stage, StagePower, Step, Units,
    WorkloadPower,
};
