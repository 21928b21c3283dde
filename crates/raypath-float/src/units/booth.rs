//! Products as rows to be added: one multiple of the multiplicand for three bits of the multiplier.
//!
//! Radix-8 Booth encoding: three bits of the multiplier and the bit to their right give a digit from -4 to 4. The small
//! number of rows is worth the adder that the multiple by three needs.

use crate::units::compress::Row;
use crate::units::lookahead;
use raypath_hdl::Wire;

/// Three times the multiplicand without its lowest bit, which is that of the multiplicand. The other multiples are
/// shifts.
pub(crate) fn triple_above(multiplicand: Wire<'_>, has_lookahead: bool) -> Wire<'_> {
    lookahead::sum(multiplicand.upper(multiplicand.width() - 1), multiplicand, has_lookahead, "triple")
}

/// Rows whose sum is `multiplicand * multiplier`, modulo 2 to the number of `columns`, at least as many as both have
/// bits together. They are in the order of their lowest columns. `triple` is three times the multiplicand.
pub(crate) fn rows<'m>(multiplicand: Wire<'m>, triple: Wire<'m>, multiplier: Wire<'m>, columns: u32) -> Vec<Row<'m>> {
    let m = multiplicand.builder();
    let digits = multiplier.width() / 3 + 1;
    let padding = m.constant(3 * digits - multiplier.width(), 0);
    let padded = m.concat(&[padding, multiplier, m.constant(1, 0)]).named("padded_multiplier");
    let multiples = Multiples::new(multiplicand, triple);
    let mut rows = Vec::new();
    // The bits that complete the complement of the row above.
    let mut correction = None;
    for digit in 0..digits {
        let name = |stem: &str| format!("{stem}_{digit}");
        let bits = padded.bits(3 * digit + 3, 3 * digit);
        let magnitude =
            multiples.select(bits.lower(3), bits.upper(3), digit, columns - 3 * digit).named(&name("magnitude"));
        let negative = bits.top().named(&name("negative"));
        let (upper, lowest) = (magnitude.upper(magnitude.width() - 1), magnitude.bit(0));
        // The negative of a number is its complement plus one: the lowest bit stays, and may carry a one into the next.
        let complemented = upper ^ negative.replicate(upper.width());
        let one = m.constant(1, 1);
        let sign = match digit {
            _ if digit + 1 == digits && digits > 1 => vec![one],
            _ if digit + 1 == digits => vec![],
            0 => vec![!negative, negative, negative, negative],
            _ => vec![one, one, !negative],
        };
        let mut word = vec![complemented, lowest];
        if let Some(correction) = correction {
            word.extend([m.constant(1, 0), correction]);
        }
        let low = if digit == 0 { 0 } else { 3 * digit - 2 };
        let end = word.iter().fold(low, |end, part| end + part.width());
        let beyond = (end + sign.len() as u32).saturating_sub(columns) as usize;
        let word = [sign.get(beyond..).unwrap_or_default(), &word].concat();
        rows.push(Row { word: m.concat(&word).named(&name("row")), low });
        if digit + 1 < digits {
            correction = Some((negative & !lowest).named(&name("correction")));
        }
    }
    rows
}

struct Multiples<'m> {
    one: Wire<'m>,
    two: Wire<'m>,
    three: Wire<'m>,
    four: Wire<'m>,
}

impl<'m> Multiples<'m> {
    fn new(multiplicand: Wire<'m>, triple: Wire<'m>) -> Self {
        let m = multiplicand.builder();
        let width = triple.width();
        Self {
            one: multiplicand.extend(width).named("once"),
            two: m.concat(&[multiplicand, m.constant(1, 0)]).extend(width).named("twice"),
            three: triple.named("thrice"),
            four: m.concat(&[multiplicand, m.constant(2, 0)]).named("four_times"),
        }
    }

    /// The lowest bits, at most `columns`, of the multiple that a digit selects. The digit's value is the number in
    /// `high` minus the number in `low`.
    fn select(&self, low: Wire<'m>, high: Wire<'m>, digit: u32, columns: u32) -> Wire<'m> {
        let name = |stem: &str| format!("{stem}_{digit}");
        let steps = (low ^ high).named(&name("steps"));
        let odd = steps.bit(0);
        let gate = |condition: Wire<'m>, stem: &str, word: Wire<'m>| {
            let width = word.width().min(columns);
            condition.named(&name(stem)).replicate(width) & word.lower(width)
        };
        let one = gate(odd & !steps.bit(2), "one", self.one);
        let two = gate(!odd & steps.bit(1), "two", self.two);
        let three = gate(odd & steps.bit(2), "three", self.three);
        let four = gate(!odd & !steps.bit(1) & steps.bit(2), "four", self.four);
        one | two | three | four
    }
}
