//! Parameters that are one of a few named values.

use std::fmt;
use thiserror::Error;

/// A name that is none of a parameter's values.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("'{given}' is no {what}, expected {expected}")]
pub struct ParseChoiceError {
    given: String,
    what: &'static str,
    expected: String,
}

impl ParseChoiceError {
    pub(crate) fn new(given: &str, what: &'static str, values: &[impl fmt::Display]) -> Self {
        Self { given: given.to_string(), what, expected: alternatives(values) }
    }
}

/// `a, b or c`: what could stand instead; `none` where nothing could.
pub fn alternatives(values: &[impl fmt::Display]) -> String {
    let names: Vec<String> = values.iter().map(ToString::to_string).collect();
    match names.as_slice() {
        [] => "none".to_string(),
        [one] => one.clone(),
        [rest @ .., last] => format!("{} or {last}", rest.join(", ")),
    }
}

/// Declares an enumeration whose values have names, with `ALL`, `Display` and `FromStr`. What stands in parentheses is
/// what messages call the parameter.
macro_rules! choices {
    (
        $(#[$attribute:meta])*
        pub enum $name:ident ($what:literal) {
            $($(#[$value_attribute:meta])* $value:ident = $text:literal,)*
        }
    ) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum $name {
            $($(#[$value_attribute])* $value,)*
        }

        impl $name {
            /// Every value.
            pub const ALL: &[Self] = &[$(Self::$value),*];
        }

        impl std::str::FromStr for $name {
            type Err = $crate::choice::ParseChoiceError;
            fn from_str(text: &str) -> Result<Self, Self::Err> {
                let found = Self::ALL.iter().copied().find(|value| value.to_string() == text);
                found.ok_or_else(|| $crate::choice::ParseChoiceError::new(text, $what, Self::ALL))
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(match self {
                    $(Self::$value => $text,)*
                })
            }
        }
    };
}
pub(crate) use choices;
