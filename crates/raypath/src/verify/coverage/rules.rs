//! Which of the rulings of `docs/reference/semantics.md` a job exercises. What is computed here decides what is
//! counted, never
//! what is right.

mod beats;
mod boxes;
mod triangles;

pub use beats::{BeatRule, Onto};
pub use boxes::{BoxRule, PERMUTATIONS, permutation};
pub use triangles::TriangleRule;

use crate::verify::layout::{Field, Layout};
use raypath_float::Format;
use raypath_ops::JobKind;

/// Numbers of a format as binary64, and arithmetic on them that is rounded into the format.
#[derive(Debug, Clone, Copy)]
pub struct Rounded(pub Format);

impl Rounded {
    #[inline]
    pub fn value(self, code: u64) -> f64 {
        if self.0 == Format::BINARY32 { f32::from_bits(code as u32).into() } else { self.0.to_f64(code) }
    }
    #[inline]
    fn round(self, number: f64) -> f64 {
        if self.0 == Format::BINARY32 { (number as f32).into() } else { self.0.to_f64(self.0.from_f64(number)) }
    }
    #[inline]
    fn add(self, a: f64, b: f64) -> f64 {
        self.round(a + b)
    }
    #[inline]
    fn sub(self, a: f64, b: f64) -> f64 {
        self.round(a - b)
    }
    #[inline]
    fn mul(self, a: f64, b: f64) -> f64 {
        self.round(a * b)
    }
}

/// Shows each field of a job with its code.
fn fields<'w>(layout: &'w Layout, kind: JobKind, words: &'w [u64]) -> impl Iterator<Item = (Field, u64)> + 'w {
    layout.fields(kind).iter().copied().zip(words.iter().copied())
}

/// Declares an enumeration of rules with what they are called.
macro_rules! rules {
    ($(#[$attribute:meta])* $type:ident { $($name:ident = $text:literal,)* }) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $type {
            $(#[doc = $text] $name,)*
        }

        impl $type {
            /// What they are called.
            pub const NAMES: &[&str] = &[$($text),*];
        }
    };
}
use rules;
