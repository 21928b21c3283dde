//! The format to which lanes of binary32 round.

use crate::kernels::{Baseline, baseline};
use crate::lanes::{Lanes, Native, Width};
use fearless_simd::prelude::*;
use raypath_float::Format;

/// What lanes do with each number that they compute in binary32.
pub trait LaneRounding<S: Simd, W: Width<S>>: Copy + 'static {
    /// The number of the format that is nearest to it, ties to even.
    fn round(self, simd: S, x: W::Nums) -> W::Nums;
    /// The number of the format that is nearest to the product, ties to even.
    #[inline(always)]
    fn multiply(self, simd: S, a: W::Nums, b: W::Nums) -> W::Nums {
        self.round(simd, a * b)
    }
    /// The format's unit in the last place of 1.
    fn ulp_of_one(self) -> f32;
}

/// Numbers stay what they are: the format is binary32.
#[derive(Debug, Clone, Copy)]
pub struct Exact;

/// Numbers are rounded to a short format.
#[derive(Debug, Clone, Copy)]
pub struct ShortFormat {
    /// The bits that binary32 has and the format has not.
    dropped: u32,
    /// The least normal number.
    least_normal: f32,
    greatest: f32,
    /// Binary32 has not all bits of the products that round to subnormal numbers.
    has_wide_range: bool,
}

/// A factor with which products that round to subnormal numbers of a short format are normal in binary32.
const SCALE: f32 = (1 << 24) as f32;

/// Lanes that round to a short format, in the SIMD instructions that every machine of the architecture has.
pub type ShortLanes = Lanes<Baseline, Native, ShortFormat>;

impl ShortFormat {
    /// Lanes of a format whose sums and products are those of binary32, rounded once more. That is so if binary32 has
    /// twice as many bits and two more (Figueroa, "When is Double Rounding Innocuous?", 1995). Products that round to
    /// subnormal numbers are scaled if binary32 has not all their bits: the format's least exponent less 3p - 1 is
    /// below -149.
    pub fn lanes(format: Format) -> Option<ShortLanes> {
        let (p, least_exponent) = (format.significand() as i32, 2 - (1 << (format.exponent() - 1)));
        let is_innocuous = 2 * p + 2 <= 24;
        let rounding = || Self {
            dropped: 24 - p as u32,
            least_normal: format.to_f64(1 << format.fraction_width()) as f32,
            greatest: format.to_f64(format.infinity() - 1) as f32,
            has_wide_range: least_exponent - 3 * p + 1 < -149,
        };
        (format.exponent() <= 8 && is_innocuous).then(|| Lanes::rounded(baseline(), rounding()))
    }
}

impl<S: Simd, W: Width<S>> LaneRounding<S, W> for Exact {
    #[inline(always)]
    fn round(self, _: S, x: W::Nums) -> W::Nums {
        x
    }
    #[inline(always)]
    fn ulp_of_one(self) -> f32 {
        f32::EPSILON
    }
}

impl<S: Simd, W: Width<S>> LaneRounding<S, W> for ShortFormat {
    #[inline(always)]
    fn round(self, simd: S, x: W::Nums) -> W::Nums {
        let word = |word: u32| W::Words::simd_from(simd, word);
        let number = |number: f32| W::Nums::simd_from(simd, number);
        let sign = x.bitcast::<W::Words>() & word(1 << 31);
        let magnitude = (x.bitcast::<W::Words>() ^ sign).bitcast::<W::Nums>();
        // Codes of magnitudes are in the order of the magnitudes: half a unit, less one if the last bit is even.
        let code = magnitude.bitcast::<W::Words>();
        let is_odd = (code >> self.dropped) & word(1);
        let normal = (code + is_odd + word((1 << (self.dropped - 1)) - 1)) & word(!((1 << self.dropped) - 1));
        let normal = normal.bitcast::<W::Nums>();
        let finite = normal.simd_gt(number(self.greatest)).select(number(f32::INFINITY), normal);
        // The unit in the last place of this number is that of subnormal numbers.
        let large = number(self.least_normal * (1 << self.dropped) as f32);
        let subnormal = (magnitude + large) - large;
        let rounded = magnitude.simd_lt(number(self.least_normal)).select(subnormal, finite);
        let rounded = magnitude.is_nan().select(magnitude, rounded);
        (rounded.bitcast::<W::Words>() | sign).bitcast()
    }
    #[inline(always)]
    fn multiply(self, simd: S, a: W::Nums, b: W::Nums) -> W::Nums {
        let product = LaneRounding::<S, W>::round(self, simd, a * b);
        if !self.has_wide_range {
            return product;
        }
        let number = |number: f32| W::Nums::simd_from(simd, number);
        // Exact, or far below half of the least number.
        let scaled = (a * number(SCALE) * b).abs();
        let large = number(self.least_normal * (1 << self.dropped) as f32 * SCALE);
        let subnormal = ((scaled + large) - large) * number(SCALE.recip());
        let is_subnormal = scaled.simd_lt(number(self.least_normal * SCALE));
        is_subnormal.select(subnormal.copysign(product), product)
    }
    #[inline(always)]
    fn ulp_of_one(self) -> f32 {
        f32::EPSILON * (1 << self.dropped) as f32
    }
}
