//! Bits and words of circuits that compute values.

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
