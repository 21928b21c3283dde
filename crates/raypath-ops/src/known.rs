//! Bits and words of circuits whose values are known.

/// What a [`Circuit`](crate::Circuit) implements for bits that are `bool` and words that are `u32`, and its multiplexers:
/// the part that is the same for all circuits whose values are known, whatever their numbers are.
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
