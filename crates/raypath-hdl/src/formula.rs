//! Constants that the text computes from other constants.

use std::ops::{Add, Mul, Shl, Sub};

/// A number and how it is computed from named numbers: `(1 << (ExpBits - 1)) + 2`. The text has the formula, the
/// netlist its value.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    value: u64,
    text: String,
    is_operation: bool,
    names: Vec<(String, u64)>,
}

impl Formula {
    /// A number with a name, which a module that uses it declares as a constant of 32 bits.
    pub fn named(name: &str, value: u64) -> Self {
        Self { value, text: name.to_string(), is_operation: false, names: vec![(name.to_string(), value)] }
    }

    /// Its value.
    pub fn value(&self) -> u64 {
        self.value
    }

    /// Its text.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// Whether it is not just a literal.
    pub(crate) fn is_derived(&self) -> bool {
        self.is_operation || !self.names.is_empty()
    }

    /// The named numbers in it.
    pub(crate) fn names(&self) -> &[(String, u64)] {
        &self.names
    }

    fn operation(self, operator: &str, other: Self, value: u64) -> Self {
        let operand = |formula: &Self| match formula.is_operation {
            true => format!("({})", formula.text),
            false => formula.text.clone(),
        };
        let text = format!("{} {operator} {}", operand(&self), operand(&other));
        let mut names = self.names;
        names.extend(other.names.into_iter().filter(|name| !names.contains(name)).collect::<Vec<_>>());
        Self { value, text, is_operation: true, names }
    }
}

impl From<u64> for Formula {
    fn from(value: u64) -> Self {
        Self { value, text: value.to_string(), is_operation: false, names: Vec::new() }
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $text:literal, $operation:ident) => {
        impl<T: Into<Formula>> $trait<T> for Formula {
            type Output = Self;
            fn $method(self, other: T) -> Self {
                let other = other.into();
                let value = self.value.$operation(other.value as _);
                self.operation($text, other, value)
            }
        }
    };
}

operator!(Add, add, "+", wrapping_add);
operator!(Sub, sub, "-", wrapping_sub);
operator!(Mul, mul, "*", wrapping_mul);
operator!(Shl, shl, "<<", wrapping_shl);
