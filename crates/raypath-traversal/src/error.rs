//! The error of a unit that cannot be built.

use crate::hardware::UnitParametersError;
use thiserror::Error;

/// The reason why a unit cannot be built.
#[derive(Debug, Error)]
pub enum UnitError {
    /// A parameter out of its range.
    #[error(transparent)]
    Parameters(#[from] UnitParametersError),
    /// A configuration of the datapath that the unit does not have.
    #[error("the unit has no datapath with {parameter} {value}, expected {expected}")]
    Datapath {
        /// The parameter of the datapath.
        parameter: &'static str,
        /// Its value.
        value: String,
        /// The values that the unit has.
        expected: &'static str,
    },
    /// The datapath cannot be elaborated.
    #[error(transparent)]
    Elaboration(#[from] raypath_rtl::Error),
    /// A defect of the unit's netlist.
    #[error(transparent)]
    Netlist(#[from] raypath_hdl::Error),
}
