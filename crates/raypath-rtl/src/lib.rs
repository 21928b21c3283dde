//! Elaboration of operations into an elastic pipeline of shared floating-point units.
//!
//! The layers of the crate, in order: `config` declares the parameters; `ir` records each operation as a graph;
//! `schedule` assigns stages and steps; `allocate` assigns units and registers; `emit` builds the netlist
//! ([`DatapathNetlist::top`]); and [`package`] writes it as files for other flows.
//!
//! ```
//! use raypath_rtl::{Config, DatapathNetlist, Lanes};
//!
//! let datapath = DatapathNetlist::new(Config::DEFAULT.lanes(Lanes::None))?;
//! assert_eq!(datapath.top().name(), "raypath");
//! assert_eq!(datapath.units(2).add, 24);
//! # Ok::<(), raypath_rtl::Error>(())
//! ```

mod allocate;
mod config;
pub mod dataflow;
mod datapath;
mod emit;
mod error;
mod fold;
mod ir;
mod operations;
pub mod package;
pub mod report;
mod schedule;

pub use config::{
    Accumulators, Choice, Config, Control, EXCEPTIONS, Encoding, Exception, Features, Interval, Lanes,
    Microarchitecture, Multiplier, OperationVisitor, PARAMETER_GROUPS, PRESETS, Parameter, ParameterGroup,
    ParseChoiceError, Preset, Semantics, Sharing, UnitLatency, UnitSharing, alternatives, parameters,
};
pub use datapath::{DatapathNetlist, Registers, StageNote, StateLoop};
pub use emit::properties::{Bind, Checker, Properties};
pub use error::{Error, Shortage};
pub use ir::graph::MAX_OPERATIONS;
pub use ir::position::{STAGES, StepLabel};
pub use ir::units::{UnitKind, Units};
pub use operations::{Operations, is_identifier};
pub use schedule::Budget;
