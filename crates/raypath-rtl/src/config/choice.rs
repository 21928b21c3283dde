//! Parameters with a few named values.

use std::fmt;
use thiserror::Error;

/// A text that is not one of a parameter's values.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("'{given}' is not a valid {what}, expected {expected}")]
pub struct ParseChoiceError {
    given: String,
    what: &'static str,
    expected: String,
}

impl ParseChoiceError {
    pub(super) fn new(given: &str, what: &'static str, values: &[impl fmt::Display]) -> Self {
        Self { given: given.to_string(), what, expected: alternatives(values) }
    }
}

/// The values as `a, b or c`, for messages that say what was expected; `none` if there are none.
pub fn alternatives(values: &[impl fmt::Display]) -> String {
    let names: Vec<String> = values.iter().map(ToString::to_string).collect();
    match names.as_slice() {
        [] => "none".to_string(),
        [one] => one.clone(),
        [rest @ .., last] => format!("{} or {last}", rest.join(", ")),
    }
}

/// Declares an enumeration whose values have texts, with `ALL`, `Display` and `FromStr`. The literal in parentheses is
/// the name of the parameter in messages.
macro_rules! choices {
    (
        $(#[$attribute:meta])*
        pub enum $name:ident ($what:literal) {
            $(#[$first_attribute:meta])* $first:ident = $first_text:literal,
            $($(#[$value_attribute:meta])* $value:ident = $text:literal,)*
        }
    ) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum $name {
            $(#[$first_attribute])* $first,
            $($(#[$value_attribute])* $value,)*
        }

        impl $name {
            /// Every value.
            pub const ALL: &[Self] = &[Self::$first $(, Self::$value)*];
        }

        impl std::str::FromStr for $name {
            type Err = $crate::config::choice::ParseChoiceError;
            fn from_str(text: &str) -> Result<Self, Self::Err> {
                let found = Self::ALL.iter().copied().find(|value| value.to_string() == text);
                found.ok_or_else(|| $crate::config::choice::ParseChoiceError::new(text, $what, Self::ALL))
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(match self {
                    Self::$first => $first_text,
                    $(Self::$value => $text,)*
                })
            }
        }

        $crate::config::values::values_by_text!($name, concat!($first_text $(, "|", $text)*), to_string);
    };
}
pub(super) use choices;
