//! Declares the rules of an operation, and iterates over a job's fields.

use crate::layout::{Field, Layout};
use raypath_ops::JobKind;

/// The fields of a job, each with its word.
pub(super) fn fields<'w>(
    layout: &'w Layout,
    kind: JobKind,
    words: &'w [u64],
) -> impl Iterator<Item = (Field, u64)> + 'w {
    layout.fields(kind).iter().copied().zip(words.iter().copied())
}

/// Declares an enumeration of rules with their names.
macro_rules! rules {
    ($(#[$attribute:meta])* $type:ident { $($name:ident = $text:literal,)* }) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $type {
            $(#[doc = $text] $name,)*
        }

        impl $type {
            /// The rules' names.
            pub const NAMES: &[&str] = &[$($text),*];
        }
    };
}
pub(super) use rules;
