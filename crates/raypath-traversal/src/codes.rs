//! Numbers with names: constants in Rust, and an enumeration in the text of the hardware.

use crate::words::WordCircuit;
use raypath_hdl::Label;
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

impl Codes {
    /// The names in the hardware, with values or, of bits, places.
    pub fn labels(self) -> impl Iterator<Item = Label> {
        let label = move |value| Label { name: self.name(value).to_string(), value: self.number(value).into() };
        self.all.iter().map(move |&(_, value)| label(value))
    }

    /// A code as a constant.
    #[inline(always)]
    pub fn word<C: WordCircuit, const W: u32>(self, c: C, value: u32) -> Word<C, W> {
        let word = c.word(value);
        c.label(format_args!("{}", self.name(value)), &word);
        word
    }

    /// Whether a word is a code.
    #[inline(always)]
    pub fn is<C: WordCircuit, const W: u32>(self, word: Word<C, W>, value: u32) -> Bit<C> {
        let c = word.circuit;
        Bit::new(c, c.word_equal(word.value, self.word::<C, W>(c, value).value))
    }

    /// A bit of a word.
    #[inline(always)]
    pub fn bit<C: WordCircuit, const W: u32>(self, word: Word<C, W>, value: u32) -> Bit<C> {
        let c = word.circuit;
        let bit = Word::<C, 1>::new(c, c.word_part(word.value, self.number(value), 1)).is(1);
        c.label(format_args!("{}", self.name(value)), &bit);
        bit
    }

    fn number(self, value: u32) -> u32 {
        self.first_bit.map_or(value, |first| first + value.trailing_zeros())
    }

    /// The name in the hardware, such as `AnswerCannotEnter`. If there is none, it is the stem.
    fn name(self, value: u32) -> impl fmt::Display {
        fmt::from_fn(move |f| {
            let name = self.all.iter().find(|(_, known)| *known == value).map_or("", |(name, _)| name);
            f.write_str(self.stem)?;
            let mut words = name.split('_').map(|word| word.split_at(word.len().min(1)));
            words.try_for_each(|(first, rest)| write!(f, "{first}{}", rest.to_lowercase()))
        })
    }
}

/// Declares a module of codes: constants, and `CODES` with their names.
macro_rules! codes {
    (
        $(#[$of_module:meta])* pub mod $module:ident: $stem:literal, $doc:literal, $first_bit:expr;
        $($(#[$of_code:meta])* $code:ident = $value:expr;)*
        $({ $($other:item)* })?
    ) => {
        $(#[$of_module])*
        pub mod $module {
            $($(#[$of_code])* pub const $code: u32 = $value;)*
            $($($other)*)?
            const ALL_CODES: &[(&str, u32)] = &[$((stringify!($code), $code)),*];
            pub(crate) const CODES: $crate::codes::Codes =
                $crate::codes::Codes { stem: $stem, doc: $doc, first_bit: $first_bit, all: ALL_CODES };
        }
    };
}
pub(crate) use codes;
