//! Methods of circuits that compute values.

/// The methods of [`Circuit`](crate::Circuit) on bits that are `bool` and words that are `u32`, and the multiplexers.
/// They are the same for all [`Concrete`](crate::Concrete) circuits. Use it inside the `impl` block.
#[macro_export]
macro_rules! known_bits_and_words {
    () => {
        #[inline(always)]
        fn constant_bit(self, value: bool) -> bool {
            value
        }
        #[inline(always)]
        fn and(self, a: bool, b: bool) -> bool {
            a & b
        }
        #[inline(always)]
        fn or(self, a: bool, b: bool) -> bool {
            a | b
        }
        #[inline(always)]
        fn not(self, a: bool) -> bool {
            !a
        }
        #[inline(always)]
        fn constant_word(self, _width: u32, value: u32) -> u32 {
            value
        }
        #[inline(always)]
        fn word_equal(self, a: u32, b: u32) -> bool {
            a == b
        }
        #[inline(always)]
        fn word_less(self, a: u32, b: u32) -> bool {
            a < b
        }
        #[inline(always)]
        fn select_num(self, condition: bool, if_true: Self::Num, if_false: Self::Num) -> Self::Num {
            if condition { if_true } else { if_false }
        }
        #[inline(always)]
        fn select_bit(self, condition: bool, if_true: bool, if_false: bool) -> bool {
            if condition { if_true } else { if_false }
        }
        #[inline(always)]
        fn select_word(self, condition: bool, if_true: u32, if_false: u32) -> u32 {
            if condition { if_true } else { if_false }
        }
    };
}

/// Implements [`Circuit`](crate::Circuit) and [`Concrete`](crate::Concrete) by the machine's instructions for numbers
/// that are a tuple structure `$number` of the native type `$float`, with the bits `$bits` and the layout `$layout`. Two
/// numbers are equal if their bits are; all NaNs are equal to the canonical one, `$nan`.
#[macro_export]
macro_rules! native_circuit {
    ($circuit:ident, $number:ident($float:ty), $bits:ty, $layout:expr, $nan:literal) => {
        impl $number {
            /// The number's bits; a NaN becomes the canonical NaN.
            #[inline(always)]
            pub fn to_bits(self) -> $bits {
                if self.0.is_nan() { $nan } else { self.0.to_bits() }
            }
        }

        impl PartialEq for $number {
            fn eq(&self, other: &Self) -> bool {
                self.to_bits() == other.to_bits()
            }
        }

        impl $crate::Circuit for $circuit {
            $crate::native_numbers!($number($float), $bits, $layout);

            #[inline(always)]
            fn add(self, a: $number, b: $number) -> $number {
                $number(a.0 + b.0)
            }
            #[inline(always)]
            fn subtract(self, a: $number, b: $number) -> $number {
                $number(a.0 - b.0)
            }
            #[inline(always)]
            fn multiply(self, a: $number, b: $number) -> $number {
                $number(a.0 * b.0)
            }

            $crate::known_bits_and_words!();
        }

        impl $crate::Concrete for $circuit {
            $crate::native_bits!($number($float), $bits);
        }
    };
}

/// The methods of [`Concrete`](crate::Concrete) for such numbers. Use it inside the `impl` block.
#[macro_export]
macro_rules! native_bits {
    ($number:ident($float:ty), $bits:ty) => {
        #[inline(always)]
        fn number(self, ieee_bits: u64) -> $number {
            $number(<$float>::from_bits(ieee_bits as $bits))
        }
        #[inline(always)]
        fn bits(self, number: $number) -> u64 {
            number.to_bits().into()
        }
        #[inline(always)]
        fn raw_bits(self, number: $number) -> u64 {
            number.0.to_bits().into()
        }
    };
}

/// The types and number methods of [`Circuit`](crate::Circuit), except addition, subtraction and multiplication, for
/// such numbers. Use it inside the `impl` block.
#[macro_export]
macro_rules! native_numbers {
    ($number:ident($float:ty), $bits:ty, $layout:expr) => {
        type Num = $number;
        type Bit = bool;
        type Word = u32;
        type Order = ($float, $float);

        #[inline(always)]
        fn constant(self, value: f32) -> $number {
            $number(value.into())
        }
        #[inline(always)]
        fn ulps(self, ulps: u32) -> $number {
            $number(ulps as $float * <$float>::EPSILON)
        }
        #[inline]
        fn sum(self, terms: &[$number]) -> $number {
            $number(<$float>::from_bits($layout.sum(terms.iter().map(|term| term.0.to_bits().into())) as $bits))
        }
        #[inline]
        fn residue(self, _product: $number, a: $number, b: $number) -> u32 {
            $layout.residue(a.0.to_bits().into(), b.0.to_bits().into())
        }
        #[inline(always)]
        fn negate(self, a: $number) -> $number {
            $number(-a.0)
        }
        #[inline(always)]
        fn narrow(self, a: $number, to: $crate::Narrowing) -> $number {
            let magnitude = a.0.abs();
            if !magnitude.is_finite() {
                return a;
            }
            let low = (1 << (<$float>::MANTISSA_DIGITS - to.bits)) - 1;
            let [code, least, margin] = [magnitude.to_bits(), <$float>::MIN_POSITIVE.to_bits(), to.margin.into()];
            // Codes of magnitudes are in the order of the magnitudes, and a step of one is a unit in the last place.
            let rounded = match to.direction {
                $crate::Direction::TowardZero => code.saturating_sub(margin) & !low,
                $crate::Direction::AwayFromZero => ((code + margin + low) & !low).min(<$float>::INFINITY.to_bits()),
            };
            let kept = if rounded < 2 * least { 0 } else { rounded };
            $number(<$float>::from_bits(kept).copysign(a.0))
        }
        #[inline(always)]
        fn compare(self, a: $number, b: $number) -> ($float, $float) {
            (a.0, b.0)
        }
        #[inline(always)]
        fn relation(self, (a, b): ($float, $float), relation: $crate::Relation) -> bool {
            match relation {
                $crate::Relation::Less => a < b,
                $crate::Relation::LessOrEqual => a <= b,
                $crate::Relation::Equal => a == b,
                $crate::Relation::GreaterOrEqual => a >= b,
                $crate::Relation::Greater => a > b,
            }
        }
        #[inline(always)]
        fn number_of(self, _width: u32, word: u32) -> $number {
            $number(word as $float)
        }
        #[inline(always)]
        fn test(self, test: $crate::Test, a: $number) -> bool {
            match test {
                $crate::Test::SignBit => a.0.is_sign_negative(),
                $crate::Test::Zero => a.0 == 0.0,
                $crate::Test::Nan => a.0.is_nan(),
                $crate::Test::AtLeastZero => a.0 >= 0.0,
                $crate::Test::AboveZero => a.0 > 0.0,
                $crate::Test::AtMostZero => a.0 <= 0.0,
                $crate::Test::BelowZero => a.0 < 0.0,
            }
        }
    };
}
