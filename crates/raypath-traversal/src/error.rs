//! The error of a unit that cannot be built.

use crate::hardware::UnitParametersError;
use thiserror::Error;

/// The reason why a unit cannot be built.
#[derive(Debug, Error)]
pub enum UnitError {
    /// A parameter out of its range.
    #[error(transparent)]
    Parameters(#[from] UnitParametersError),
    /// A parameter of the datapath that the unit has at its default alone
    /// ([`fixed_parameters`](crate::fixed_parameters)).
    #[error("the unit has no datapath with {parameter} {value}, expected {parameter} {expected}")]
    Datapath {
        /// The parameter of the datapath.
        parameter: &'static str,
        /// Its value.
        value: String,
        /// The value that the unit has.
        expected: String,
    },
    /// The datapath cannot be elaborated.
    #[error(transparent)]
    Elaboration(#[from] raypath_rtl::Error),
    /// A module of the unit whose text does not follow from the parameters.
    #[error("the text of {module} for these parameters is not that for others with other numbers")]
    Text {
        /// The module.
        module: String,
    },
    /// A defect of the unit's netlist.
    #[error(transparent)]
    Netlist(#[from] raypath_hdl::Error),
}
