//! Operands that make sums, products, quotients and comparisons hard, in any format.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_float::Format;
use std::ops::Range;

/// The number of cases: a twentieth in an unoptimised build.
pub fn cases(optimised: u32) -> u32 {
    if cfg!(debug_assertions) { optimised / 20 } else { optimised }
}

/// A generator of operands, the same in every run.
pub struct Operands {
    pub rng: ChaCha8Rng,
    fraction_width: u32,
    /// The exponent field of infinities and NaNs.
    top: u64,
}

impl Operands {
    pub fn new(format: Format, seed: u64) -> Self {
        Self {
            rng: ChaCha8Rng::seed_from_u64(seed),
            fraction_width: format.significand() - 1,
            top: (1 << format.exponent()) - 1,
        }
    }

    /// Two codes.
    pub fn pair(&mut self) -> (u64, u64) {
        let a = self.code();
        let exponent = (a >> self.fraction_width & self.top) as i64;
        let width = i64::from(self.fraction_width) + 1;
        let bias = (self.top / 2) as i64;
        let b = match self.rng.random_range(0..10) {
            0 => self.code(),
            // Sums that cancel down to the last places or need one place more.
            1 => (a ^ self.sign_bit()).wrapping_add_signed(self.rng.random_range(-3..4)),
            2 => a.wrapping_add_signed(self.rng.random_range(-3..4)),
            // Sums in which the bits of one operand decide the rounding of the other's last place.
            3..6 => self.near(exponent, -width - 4..width + 5),
            // Products in and below the subnormal range, and near the largest number.
            6 => self.near(bias - exponent, -width - 3..4),
            7 => self.near(3 * bias - exponent, -3..4),
            // Quotients in and below the subnormal range, and by powers of two, which are ties there.
            8 => self.near(exponent + bias, -3..width + 3),
            _ => self.near(exponent + bias, -3..width + 3) >> self.fraction_width << self.fraction_width,
        } & (self.sign_bit() * 2 - 1);
        if self.rng.random() { (a, b) } else { (b, a) }
    }

    /// A code with any exponent, more often the lowest and the highest, and a fraction that makes ties or carries.
    pub fn code(&mut self) -> u64 {
        let top = self.top as i64;
        match self.rng.random_range(0..8) {
            0 => self.near(0, 0..3),
            1 => self.near(top, -2..1),
            _ => self.near(0, 0..top + 1),
        }
    }

    /// A code whose exponent field differs from `exponent` by one of these, clamped to the range.
    fn near(&mut self, exponent: i64, offsets: Range<i64>) -> u64 {
        let exponent = (exponent + self.rng.random_range(offsets)).clamp(0, self.top as i64) as u64;
        let sign = if self.rng.random() { self.sign_bit() } else { 0 };
        sign | exponent << self.fraction_width | self.fraction()
    }

    /// Random, few leading bits, few trailing bits, runs of ones.
    fn fraction(&mut self) -> u64 {
        let all = (1 << self.fraction_width) - 1;
        let bits = self.rng.random_range(0..=all);
        let place = self.rng.random_range(0..=self.fraction_width);
        match self.rng.random_range(0..6) {
            0 | 1 => bits,
            2 => bits & (all << place),
            3 => bits & (all >> place),
            4 => all & (all << place),
            _ => all >> place,
        }
    }

    fn sign_bit(&self) -> u64 {
        (self.top + 1) << self.fraction_width
    }
}
