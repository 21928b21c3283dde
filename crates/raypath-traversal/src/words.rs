//! Arithmetic on words, which the control of the unit needs beside that of [`Circuit`].

use raypath_ops::{Binary32, Bit, Circuit, Select, Single, Word};

/// Names of values in the text of the hardware.
macro_rules! label {
    ($c:ident: $($value:ident),*) => {
        $($c.label(format_args!(stringify!($value)), &$value);)*
    };
}
pub(crate) use label;

/// A circuit with arithmetic on words. Widths are in bits, from 1 to 32; bits beyond the width of a word are 0.
pub trait WordCircuit: Circuit {
    /// The sum modulo 2^`width`.
    fn word_add(self, width: u32, a: Self::Word, b: Self::Word) -> Self::Word;
    /// The `width` bits from bit `low` of a word of at least `low` + `width` bits.
    fn word_part(self, a: Self::Word, low: u32, width: u32) -> Self::Word;
    /// A word of `high_width` + `low_width` bits.
    fn word_join(self, high: (u32, Self::Word), low: (u32, Self::Word)) -> Self::Word;
    /// A bit as a word of one bit.
    fn word_of_bit(self, a: Self::Bit) -> Self::Word;
    /// Bit `index` of a word of 32 bits. The index has 5 bits.
    fn word_bit(self, a: Self::Word, index: Self::Word) -> Self::Bit;
    /// The word of 32 bits of which only bit `index` is set. The index has 5 bits.
    fn word_one_hot(self, index: Self::Word) -> Self::Word;
    /// The number in binary32 with the 32 bits of a word.
    fn number_of_bits(self, a: Self::Word) -> Self::Num;
    /// The words' bits that are set in both.
    fn word_and(self, width: u32, a: Self::Word, b: Self::Word) -> Self::Word;
    /// The words' bits that are set in either.
    fn word_or(self, width: u32, a: Self::Word, b: Self::Word) -> Self::Word;
    /// The word with each bit inverted.
    fn word_not(self, width: u32, a: Self::Word) -> Self::Word;
    /// The index, of 5 bits, of the highest set bit of a word of 32 bits; 0 if none is set.
    fn word_highest(self, a: Self::Word) -> Self::Word;
    /// Whether a number is neither infinite nor NaN.
    fn is_finite(self, a: Self::Num) -> Self::Bit;
}

impl WordCircuit for Binary32 {
    #[inline(always)]
    fn word_add(self, width: u32, a: u32, b: u32) -> u32 {
        a.wrapping_add(b) & mask(width)
    }
    #[inline(always)]
    fn word_part(self, a: u32, low: u32, width: u32) -> u32 {
        a >> low & mask(width)
    }
    #[inline(always)]
    fn word_join(self, (_, high): (u32, u32), (low_width, low): (u32, u32)) -> u32 {
        high << low_width | low
    }
    #[inline(always)]
    fn word_of_bit(self, a: bool) -> u32 {
        a.into()
    }
    #[inline(always)]
    fn word_bit(self, a: u32, index: u32) -> bool {
        a >> index & 1 == 1
    }
    #[inline(always)]
    fn word_one_hot(self, index: u32) -> u32 {
        1 << index
    }
    #[inline(always)]
    fn number_of_bits(self, a: u32) -> Single {
        Single(f32::from_bits(a))
    }
    #[inline(always)]
    fn word_and(self, _width: u32, a: u32, b: u32) -> u32 {
        a & b
    }
    #[inline(always)]
    fn word_or(self, _width: u32, a: u32, b: u32) -> u32 {
        a | b
    }
    #[inline(always)]
    fn word_not(self, width: u32, a: u32) -> u32 {
        !a & mask(width)
    }
    #[inline(always)]
    fn word_highest(self, a: u32) -> u32 {
        a.checked_ilog2().unwrap_or(0)
    }
    #[inline(always)]
    fn is_finite(self, a: Single) -> bool {
        a.0.is_finite()
    }
}

#[inline(always)]
fn mask(width: u32) -> u32 {
    u32::MAX >> (32 - width)
}

/// Methods of words over a [`WordCircuit`].
pub trait WordMethods<C: WordCircuit, const W: u32>: Sized {
    /// The sum with another word, modulo 2^`W`.
    fn plus(self, other: Self) -> Self;
    /// The sum with a constant, modulo 2^`W`.
    fn plus_constant(self, constant: u32) -> Self;
    /// The `N` bits from bit `LOW`.
    fn part<const LOW: u32, const N: u32>(self) -> Word<C, N>;
    /// The word with zeros above it: `N` is at least `W`.
    fn widened<const N: u32>(self) -> Word<C, N>;
}

impl<C: WordCircuit, const W: u32> WordMethods<C, W> for Word<C, W> {
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Word::new(self.circuit, self.circuit.word_add(W, self.value, other.value))
    }
    #[inline(always)]
    fn plus_constant(self, constant: u32) -> Self {
        self.plus(self.circuit.word(constant))
    }
    #[inline(always)]
    fn part<const LOW: u32, const N: u32>(self) -> Word<C, N> {
        const { assert!(LOW + N <= W, "a part lies inside its word") };
        Word::new(self.circuit, self.circuit.word_part(self.value, LOW, N))
    }
    #[inline(always)]
    fn widened<const N: u32>(self) -> Word<C, N> {
        const { assert!(N >= W, "a word does not become narrower") };
        if N == W {
            return Word::new(self.circuit, self.value);
        }
        let c = self.circuit;
        let zeros = (N - W, c.constant_word(N - W, 0));
        Word::new(c, c.word_join(zeros, (W, self.value)))
    }
}

/// The number of levels of a tree that a ray can descend: those of [`Levels`].
pub const LEVELS: u32 = 64;

raypath_ops::bundle! {
    /// A set of levels, 0 to 63.
    pub struct Levels<C> {
        /// Levels 0 to 31.
        pub low: Word<C, 32>,
        /// Levels 32 to 63.
        pub high: Word<C, 32>,
    }
}

impl<C: WordCircuit> Levels<C> {
    /// No level.
    #[inline(always)]
    pub fn none(c: C) -> Self {
        Self { low: c.word(0), high: c.word(0) }
    }

    /// Whether it is empty.
    #[inline(always)]
    pub fn is_empty(self) -> Bit<C> {
        self.low.is(0) & self.high.is(0)
    }

    /// Whether it has a level below 64.
    #[inline(always)]
    pub fn has(self, level: Word<C, 7>) -> Bit<C> {
        let c = self.low.circuit;
        let index = level.part::<0, 5>();
        let bit = |word: Word<C, 32>| Bit::new(c, c.word_bit(word.value, index.value));
        level.part::<5, 1>().is(1).select(bit(self.high), bit(self.low))
    }

    /// Only a level below 64 if `present`, else no level.
    #[inline(always)]
    pub fn only(level: Word<C, 7>, present: Bit<C>) -> Self {
        let c = level.circuit;
        let bit_of_level = Word::<C, 32>::new(c, c.word_one_hot(level.part::<0, 5>().value));
        label!(c: bit_of_level);
        let is_high = level.part::<5, 1>().is(1);
        let of = |is_here: Bit<C>| (present & is_here).select(bit_of_level, c.word(0));
        Self { low: of(!is_high), high: of(is_high) }
    }

    /// The set with or without the levels of another.
    #[inline(always)]
    pub fn with(self, others: Self, present: Bit<C>) -> Self {
        let c = self.low.circuit;
        let of = |word: Word<C, 32>, others: Word<C, 32>| {
            let added = present.select(others, c.word(0));
            let kept = c.word_and(32, word.value, c.word_not(32, others.value));
            Word::new(c, c.word_or(32, kept, added.value))
        };
        Self { low: of(self.low, others.low), high: of(self.high, others.high) }
    }

    /// The levels below a level, which is less than 64.
    #[inline(always)]
    pub fn below(self, level: Word<C, 7>) -> Self {
        let c = self.low.circuit;
        let lower = Word::<C, 32>::new(c, c.word_one_hot(level.part::<0, 5>().value)).plus_constant(u32::MAX);
        c.label(format_args!("lower_levels"), &lower);
        let masked = |word: Word<C, 32>| Word::new(c, c.word_and(32, word.value, lower.value));
        let is_high = level.part::<5, 1>().is(1);
        Self { low: is_high.select(self.low, masked(self.low)), high: is_high.select(masked(self.high), c.word(0)) }
    }

    /// The deepest level; 0 if there is none.
    #[inline(always)]
    pub fn deepest(self) -> Word<C, 7> {
        let c = self.low.circuit;
        let highest = |word: Word<C, 32>| Word::<C, 5>::new(c, c.word_highest(word.value));
        let in_low = self.high.is(0);
        let index = in_low.select(highest(self.low), highest(self.high));
        let half = c.word_of_bit((!in_low).value);
        label!(c: in_low, index);
        Word::<C, 6>::new(c, c.word_join((1, half), (5, index.value))).widened()
    }
}

impl<C: Circuit> Select<C> for Levels<C> {
    #[inline(always)]
    fn select(condition: Bit<C>, if_true: Self, if_false: Self) -> Self {
        Self { low: condition.select(if_true.low, if_false.low), high: condition.select(if_true.high, if_false.high) }
    }
}
