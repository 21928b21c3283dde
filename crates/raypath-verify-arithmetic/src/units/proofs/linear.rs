//! Equations between sums of signals times powers of two, modulo a power of two.

use super::lemma::Signal;
use std::collections::BTreeMap;
use std::fmt::Write;

/// A term of a sum.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Term {
    /// 1.
    One,
    /// The value of a signal.
    Signal(String),
    /// A digit of the multiplier, by its position, times the multiplicand.
    Digit(u32),
    /// A bit of the multiplier, times the multiplicand.
    Bit(u32),
}

/// A sum of terms times coefficients, modulo 2 to the number of columns, which is less than 64.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sum {
    columns: u32,
    /// No coefficient is 0.
    terms: BTreeMap<Term, u64>,
}

impl Sum {
    /// The empty sum.
    pub fn new(columns: u32) -> Self {
        Self { columns, terms: BTreeMap::new() }
    }

    /// The sum with a term more.
    pub fn plus(mut self, term: Term, coefficient: i128) -> Self {
        let modulus = 1_i128 << self.columns;
        let old = self.terms.remove(&term).unwrap_or(0);
        let new = (i128::from(old) + coefficient).rem_euclid(modulus);
        if new != 0 {
            // Below the modulus.
            self.terms.insert(term, new as u64);
        }
        self
    }

    /// The sum with a signal more, whose lowest bit has the weight of a column.
    pub fn plus_signal(self, signal: &Signal, column: u32) -> Self {
        self.plus(Term::Signal(signal.name.clone()), 1 << column)
    }

    /// The sum with another one more, `sign` times.
    pub fn plus_sum(self, other: &Self, sign: i128) -> Self {
        other.terms.iter().fold(self, |sum, (term, &value)| sum.plus(term.clone(), sign * i128::from(value)))
    }

    /// The sum with each term replaced by a sum.
    pub fn map(&self, replacement: impl Fn(&Term) -> Self) -> Self {
        let begin = Self::new(self.columns);
        self.terms.iter().fold(begin, |sum, (term, &value)| sum.plus_sum(&replacement(term), i128::from(value)))
    }

    /// The sum as an expression of SystemVerilog. `name` gives the wire of each term but 1.
    pub fn expression(&self, name: impl Fn(&Term) -> String) -> String {
        let columns = self.columns;
        let mut text = format!("{columns}'d0");
        for (term, value) in &self.terms {
            match term {
                Term::One => _ = write!(text, " + {columns}'d{value}"),
                // Signals have a power of two.
                _ if value.is_power_of_two() => _ = write!(text, " + ({} << {})", name(term), value.ilog2()),
                _ => _ = write!(text, " + {} * {columns}'d{value}", name(term)),
            }
        }
        text
    }
}

/// Two sums that are equal modulo 2 to the number of their columns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Equation {
    /// One side.
    pub left: Sum,
    /// The other side.
    pub right: Sum,
}

/// The digit of the multiplier, from -4 to 4, for three of its bits and the one to their right.
pub fn digit(bits: u32) -> i128 {
    let bit = |position: u32| i128::from(bits >> position & 1);
    bit(0) + bit(1) + 2 * bit(2) - 4 * bit(3)
}

/// Derives the product of the multiplicand and a multiplier of `bits` bits from the sum of the last rows and the
/// equations, each used once. The digits read the lowest `read` bits, with zeros around them.
///
/// # Errors
/// The terms that are left over.
pub fn derive_product(last: &Sum, equations: &[&Equation], read: u32, bits: u32) -> Result<(), String> {
    let replaced = equations
        .iter()
        .fold(last.clone(), |sum, equation| sum.plus_sum(&equation.right, 1).plus_sum(&equation.left, -1));
    let empty = || Sum::new(last.columns);
    // Bit i of the word of digits is bit i - 1 of the multiplier.
    let of_digit = |number: u32| {
        let places = (0..4).map(|position| ((3 * number + position).checked_sub(1), digit(1 << position)));
        let read = places.filter_map(|(place, weight)| Some((place.filter(|place| *place < read)?, weight)));
        read.fold(empty(), |sum, (place, weight)| sum.plus(Term::Bit(place), weight))
    };
    let in_bits = replaced.map(|term| match *term {
        Term::Digit(number) => of_digit(number),
        ref other => empty().plus(other.clone(), 1),
    });
    let product = (0..bits).fold(empty(), |sum, place| sum.plus(Term::Bit(place), 1 << place));
    let rest = in_bits.plus_sum(&product, -1);
    if rest.terms.is_empty() { Ok(()) } else { Err(format!("the rows differ from the product by {:?}", rest.terms)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLUMNS: u32 = 10;

    /// Two rows, of the digits of a multiplier of five bits, the first with a correction that the second adds.
    fn equations() -> [Equation; 2] {
        let [first, second, correction] = ["first", "second", "correction"].map(|name| Signal::new(name, 6));
        let sum = || Sum::new(COLUMNS);
        [
            Equation {
                left: sum().plus_signal(&first, 0).plus_signal(&correction, 1),
                right: sum().plus(Term::Digit(0), 1).plus(Term::One, 1 << 8),
            },
            Equation {
                left: sum().plus_signal(&second, 1),
                right: sum().plus(Term::Digit(1), 8).plus_signal(&correction, 1).plus(Term::One, -(1 << 8)),
            },
        ]
    }

    #[test]
    fn a_product_follows_from_its_rows() {
        let rows = ["first", "second"].map(|name| Signal::new(name, 6));
        let last = Sum::new(COLUMNS).plus_signal(&rows[0], 0).plus_signal(&rows[1], 1);
        let [first, second] = equations();
        assert_eq!(derive_product(&last, &[&first, &second], 5, 5), Ok(()));
        // An equation is missing; is used twice; has another constant; the digits read fewer bits; a row is elsewhere.
        let other = Equation { right: second.right.clone().plus(Term::One, 1), ..second.clone() };
        let elsewhere = Sum::new(COLUMNS).plus_signal(&rows[0], 0).plus_signal(&rows[1], 2);
        for (last, equations, read) in [
            (&last, vec![&first], 5),
            (&last, vec![&first, &second, &second], 5),
            (&last, vec![&first, &other], 5),
            (&last, vec![&first, &second], 4),
            (&elsewhere, vec![&first, &second], 5),
        ] {
            assert!(derive_product(last, &equations, read, 5).is_err(), "{equations:?}");
        }
    }
}
