//! The configuration of a datapath: what it computes ([`Semantics`]) and how it is built ([`Microarchitecture`]).
//!
//! Each parameter is declared once, in one of the `declare_parameters!` blocks of `declarations.rs`. The struct's
//! field, its default, the command-line flag, the TOML key, the help text and the table in the documents follow from
//! the declaration ([`Parameter`]). The combinations that are refused are declared in `exceptions.rs` ([`EXCEPTIONS`]).

mod choice;
mod declarations;
mod enumerations;
mod exceptions;
mod operations;
mod parameter;
mod preset;
mod values;

pub use choice::{ParseChoiceError, alternatives};
pub use declarations::{Config, Features, Microarchitecture, PARAMETER_GROUPS, Semantics, parameters};
pub use enumerations::{
    Accumulators, Control, Encoding, Interval, Lanes, Multiplier, Sharing, UnitLatency, UnitSharing,
};
pub use exceptions::{Choice, EXCEPTIONS, Exception};
pub use operations::OperationVisitor;
pub use parameter::{Parameter, ParameterGroup};
pub use preset::{PRESETS, Preset};
