//! The numbers of a format and their codes, by the definitions of IEEE 754 and of the recoded format, without the
//! units' algorithms. Exponents have up to 10 bits.

use raypath_float::Format;

/// A format and all its finite magnitudes in order; the index of a magnitude is its IEEE 754 code.
pub struct Exact {
    pub format: Format,
    magnitudes: Vec<f64>,
}

impl Exact {
    pub fn new(exponent: u32, significand: u32) -> Self {
        let format = Format::new(exponent, significand).expect("a format of the test's choosing");
        let infinity = infinity_code(format);
        let magnitudes: Vec<f64> = (0..infinity).map(|code| magnitude(format, code)).collect();
        Self { format, magnitudes }
    }

    /// Every IEEE 754 code.
    pub fn ieee_codes(&self) -> impl Iterator<Item = u64> + use<> {
        0..1 << self.format.ieee_width()
    }

    /// Every word that a unit accepts as a recoded number, with its value.
    pub fn recoded_words(&self) -> Vec<(u64, f64)> {
        let words = 0..1_u64 << self.format.recoded_width();
        words.filter_map(|word| Some((word, self.recoded_value(word)?))).collect()
    }

    /// The number of an IEEE 754 code.
    pub fn ieee_value(&self, code: u64) -> f64 {
        let sign_bit = 1 << (self.format.ieee_width() - 1);
        let magnitude_code = code & (sign_bit - 1);
        let magnitude = match magnitude_code.cmp(&infinity_code(self.format)) {
            std::cmp::Ordering::Less => self.magnitudes[magnitude_code as usize],
            std::cmp::Ordering::Equal => f64::INFINITY,
            std::cmp::Ordering::Greater => return f64::NAN,
        };
        if code & sign_bit == 0 { magnitude } else { -magnitude }
    }

    /// The code of a number of the format; NaN is canonical.
    pub fn ieee_code(&self, number: f64) -> u64 {
        if number.is_nan() {
            return infinity_code(self.format) | 1 << (self.format.significand() - 2);
        }
        let code = self.magnitudes.partition_point(|&magnitude| magnitude < number.abs());
        u64::from(number.is_sign_negative()) << (self.format.ieee_width() - 1) | code as u64
    }

    /// The canonical recoded form of a number of the format, by the table in the specification.
    pub fn recoded_word(&self, number: f64) -> u64 {
        let (e, fraction_width) = (self.format.exponent(), self.format.significand() - 1);
        if number.is_nan() {
            return (0b111 << (e - 2)) << fraction_width | 1 << (fraction_width - 1);
        }
        let magnitude = number.abs();
        let (exponent, fraction) = if magnitude == 0.0 {
            (0, 0)
        } else if magnitude.is_infinite() {
            (0b110 << (e - 2), 0)
        } else {
            let true_exponent = floor_log2(magnitude);
            let fraction = (magnitude / exp2(true_exponent) - 1.0) * exp2(fraction_width as i32);
            assert_eq!(fraction.fract(), 0.0, "{number} is no number of {}", self.format);
            ((true_exponent + (1 << e)) as u64, fraction as u64)
        };
        u64::from(number.is_sign_negative()) << self.format.ieee_width() | exponent << fraction_width | fraction
    }

    /// The number of a recoded word; `None` if the word is not a number of the format.
    fn recoded_value(&self, word: u64) -> Option<f64> {
        let (e, fraction_width) = (self.format.exponent(), self.format.significand() - 1);
        let fraction = word & ((1 << fraction_width) - 1);
        let exponent = word >> fraction_width & ((1 << (e + 1)) - 1);
        let magnitude = match exponent >> (e - 2) {
            0b000 if fraction == 0 => 0.0,
            0b000 => return None,
            0b110 => f64::INFINITY,
            0b111 => return Some(f64::NAN),
            _ => (1.0 + fraction as f64 / exp2(fraction_width as i32)) * exp2(exponent as i32 - (1 << e)),
        };
        let known = magnitude.is_infinite() || self.magnitudes.binary_search_by(|m| m.total_cmp(&magnitude)).is_ok();
        known.then_some(if word >> self.format.ieee_width() & 1 == 0 { magnitude } else { -magnitude })
    }
}

fn magnitude(format: Format, code: u64) -> f64 {
    let fraction_width = format.significand() - 1;
    let fraction = (code & ((1 << fraction_width) - 1)) as f64 / exp2(fraction_width as i32);
    let exponent = (code >> fraction_width) as i32;
    let bias = largest_exponent(format);
    if exponent == 0 { fraction * exp2(1 - bias) } else { (1.0 + fraction) * exp2(exponent - bias) }
}

fn infinity_code(format: Format) -> u64 {
    ((1 << format.exponent()) - 1) << (format.significand() - 1)
}

/// The exponent of the largest numbers, which is also IEEE 754's bias.
fn largest_exponent(format: Format) -> i32 {
    (1 << (format.exponent() - 1)) - 1
}

fn exp2(exponent: i32) -> f64 {
    2.0_f64.powi(exponent)
}

fn floor_log2(magnitude: f64) -> i32 {
    (magnitude.to_bits() >> 52) as i32 - 1023
}
