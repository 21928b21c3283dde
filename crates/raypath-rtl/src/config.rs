//! The configuration of a datapath: what it computes ([`Semantics`]) and how it is built ([`Microarchitecture`]).
//!
//! Each parameter is declared once, in one of the three `declare_parameters!` blocks. The struct's field, its default,
//! the command-line flag, the TOML key, the help text and the table in the documents follow from the declaration
//! ([`Parameter`]).

mod choice;
mod features;
mod microarchitecture;
mod operations;
mod parameter;
mod preset;
mod semantics;

pub use choice::{ParseChoiceError, alternatives};
pub use features::{Accumulators, Features};
pub use microarchitecture::{Control, Encoding, Microarchitecture, Sharing, UnitLatency};
pub use operations::OperationVisitor;
pub use parameter::{PARAMETER_GROUPS, Parameter, ParameterGroup, parameters};
pub use preset::{PRESETS, Preset};
pub use semantics::{Lanes, Semantics};

use crate::error::Error;
use raypath_ops::JobKind;
use std::fmt;

/// A configuration of the paper's operations. The default has all four of them.
///
/// Each parameter has a method of its name that returns a changed copy:
///
/// ```
/// use raypath_rtl::{Config, Control, Lanes};
///
/// let config = Config::DEFAULT.lanes(Lanes::Four).control(Control::Credit);
/// assert_eq!(config.options(), "--lanes 4 --control credit");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Config {
    /// What the datapath computes.
    pub semantics: Semantics,
    /// How the datapath is built.
    pub microarchitecture: Microarchitecture,
}

impl Config {
    /// Every parameter at its default.
    pub const DEFAULT: Self = Self { semantics: Semantics::DEFAULT, microarchitecture: Microarchitecture::DEFAULT };

    /// This configuration with these features.
    pub const fn features(mut self, features: Features) -> Self {
        self.semantics.features = features;
        self
    }

    /// The kinds of jobs that the datapath accepts.
    pub fn kinds(self) -> &'static [JobKind] {
        self.semantics.kinds()
    }

    /// Checks that the parameters can be combined.
    ///
    /// # Errors
    /// Those of [`Semantics::check`].
    pub fn check(self) -> Result<(), Error> {
        self.semantics.check()
    }

    /// The command-line options that select this configuration, such as `--lanes none --control credit`; empty for the
    /// default.
    pub fn options(self) -> String {
        let option = |parameter: &Parameter| match parameter.get(&self).as_str() {
            "true" => format!("--{}", parameter.name),
            value => format!("--{} {value}", parameter.name),
        };
        let changed = parameters().filter(|parameter| parameter.get(&self) != parameter.default());
        changed.map(option).collect::<Vec<_>>().join(" ")
    }
}

/// Parameters that [`Config`]'s `Display` shows even if they have their default values.
const ALWAYS_SHOWN: [&str; 2] = ["lanes", "rules"];

/// The lanes, the rules, and each other parameter that differs from its default.
impl fmt::Display for Config {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        for parameter in parameters() {
            let value = parameter.get(self);
            if ALWAYS_SHOWN.contains(&parameter.name) || value != parameter.default() {
                write!(f, "{separator}{} {value}", parameter.name.replace('-', " "))?;
                separator = ", ";
            }
        }
        Ok(())
    }
}
