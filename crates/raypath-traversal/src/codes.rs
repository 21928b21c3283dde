//! Numbers with names: constants in Rust, and an enumeration in the text of the hardware.

use crate::words::WordCircuit;
use raypath_ops::{Bit, Word};
use std::fmt;

/// The values of a word that have names, or the bits of a word.
#[derive(Debug, Clone, Copy)]
pub struct Codes {
    /// The beginning of each name in the hardware.
    pub stem: &'static str,
    /// What the hardware's comment says of them.
    pub doc: &'static str,
    /// Of bits: the place in the word of the bit with the value 1.
    pub first_bit: Option<u32>,
    /// Names, in capital letters, and values. Those of bits have one bit.
    pub all: &'static [(&'static str, u32)],
}

/// The name of a code in the hardware: `AnswerCannotEnter`.
struct Name<'a>(&'a Codes, u32);

impl Codes {
    /// The names in the hardware and the numbers there: values, or places of bits.
    pub fn labels(&self) -> impl Iterator<Item = (String, u32)> {
        self.all.iter().map(|&(_, value)| (self.name(value).to_string(), self.number(value)))
    }

    /// The name in the hardware. If there is none, it is the stem.
    pub fn name(&self, value: u32) -> impl fmt::Display {
        Name(self, value)
    }

    /// A code as a constant.
    #[inline(always)]
    pub fn word<C: WordCircuit, const W: u32>(&self, c: C, value: u32) -> Word<C, W> {
        let word = c.word(value);
        c.label(format_args!("{}", self.name(value)), &word);
        word
    }

    /// Whether a word is a code.
    #[inline(always)]
    pub fn is<C: WordCircuit, const W: u32>(&self, word: Word<C, W>, value: u32) -> Bit<C> {
        let c = word.circuit;
        Bit::new(c, c.word_equal(word.value, self.word::<C, W>(c, value).value))
    }

    /// A bit of a word.
    #[inline(always)]
    pub fn bit<C: WordCircuit, const W: u32>(&self, word: Word<C, W>, value: u32) -> Bit<C> {
        let c = word.circuit;
        let bit = Word::<C, 1>::new(c, c.word_part(word.value, self.number(value), 1)).is(1);
        c.label(format_args!("{}", self.name(value)), &bit);
        bit
    }

    fn number(&self, value: u32) -> u32 {
        self.first_bit.map_or(value, |first| first + value.trailing_zeros())
    }
}

impl fmt::Display for Name<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(codes, value) = self;
        let name = codes.all.iter().find(|(_, known)| known == value).map_or("", |(name, _)| name);
        f.write_str(codes.stem)?;
        name.split('_').try_for_each(|word| {
            let (first, rest) = word.split_at(word.len().min(1));
            write!(f, "{first}{}", rest.to_lowercase())
        })
    }
}

/// Declares a module of codes: constants, and `CODES` with their names.
macro_rules! codes {
    (
        $(#[$of_module:meta])* pub mod $module:ident: $stem:literal, $text:literal, $first_bit:expr;
        $($(#[$of_code:meta])* $code:ident = $value:expr;)*
        $({ $($other:item)* })?
    ) => {
        $(#[$of_module])*
        pub mod $module {
            $($(#[$of_code])* pub const $code: u32 = $value;)*
            $($($other)*)?
            pub(crate) const CODES: $crate::codes::Codes = $crate::codes::Codes {
                stem: $stem,
                doc: $text,
                first_bit: $first_bit,
                all: &[$((stringify!($code), $code)),*],
            };
        }
    };
}
pub(crate) use codes;
