//! Elaboration: operations become an elastic pipeline of shared units.
//!
//! An operation is run once over a circuit that records it (`graph.rs`). From the record follow the units of each
//! stage, the registers between them and the ports (`plan.rs`); from those the netlist ([`Datapath::top`]).
//!
//! ```
//! use raypath_rtl::{Config, Datapath, Lanes};
//!
//! let datapath = Datapath::new(Config::DEFAULT.lanes(Lanes::None))?;
//! assert_eq!(datapath.top().name(), "raypath");
//! assert_eq!(datapath.units(2).add, 24);
//! # Ok::<(), raypath_rtl::Error>(())
//! ```

mod binding;
mod boundary;
mod budget;
mod config;
mod control;
mod datapath;
mod demand;
mod elastic;
mod error;
mod graph;
mod input;
mod library;
mod liveness;
mod output;
pub mod package;
mod place;
mod plan;
mod properties;
pub mod report;
mod schedule;
mod stage;
mod steps;
mod top;
mod tracer;
mod units;
mod values;

pub use budget::{Budget, Shortage};
pub use config::{
    Accumulators, Config, Control, Encoding, Features, Lanes, Microarchitecture, OperationVisitor, PARAMETER_GROUPS,
    PRESETS, Parameter, ParameterGroup, ParseChoiceError, Preset, Semantics, Sharing, UnitLatency, alternatives,
    parameters,
};
pub use datapath::{Datapath, MOST_OPERATIONS, Operations, Registers, StageNote, StateLoop};
pub use error::Error;
pub use properties::{Bind, Checker, Properties};
pub use steps::Step;
pub use units::{UnitKind, Units};

/// The stages between the input's registers and the output's (Table VII).
pub const STAGES: u32 = 11;
