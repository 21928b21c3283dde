//! Modules with faults, and the results of their checks.

use super::units::Unit;
use raypath_hdl::Module;
use raypath_hdl::mutate::Fault;
use raypath_model::Shape;
use raypath_rtl::Config;
use std::sync::Arc;

/// A module of a datapath, and the faults that it can have.
pub struct Subject {
    pub datapath: Arc<Elaborated>,
    pub module: Arc<Module>,
    /// The floating-point unit that the module is a part of, if any.
    pub unit: Option<Unit>,
    pub faults: Vec<Fault>,
}

/// A configuration's netlist and pipeline shape.
pub struct Elaborated {
    pub config: Config,
    pub top: Arc<Module>,
    pub shape: Shape,
}

/// A module with one of its faults.
pub struct Mutant<'s> {
    pub subject: &'s Subject,
    pub fault: &'s Fault,
}

/// The result of checking a mutant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MutantResult {
    /// This check failed.
    Killed(&'static str),
    /// No check failed, and this proof shows that the fault changes nothing.
    Equivalent(&'static str),
    /// No check failed, and the proof had this result.
    Survived(String),
}
