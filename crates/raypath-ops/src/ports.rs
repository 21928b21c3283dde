//! Conversion of bundles to and from port values: by name, or (faster) as words in the order of the ports.

use crate::{Binary32, Bit, Bundle, Concrete, Field, Num, Path, Sink, Source};
use std::slice;

/// The value of one port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PortValue {
    /// The port's name without direction suffix: `ray_origin_x`.
    pub name: String,
    /// The meaning of the bits.
    pub kind: PortKind,
    /// The value; a number is in the IEEE 754 layout.
    pub bits: u64,
}

/// The meaning of a port's bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PortKind {
    /// A floating-point number.
    Number,
    /// One truth value, or several, one per bit.
    Flags,
    /// An unsigned word.
    Word,
}

/// The declaration of a port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Port {
    /// The port's name without direction suffix: `ray_origin_x`.
    pub name: String,
    /// The meaning of the bits.
    pub kind: PortKind,
    /// The width in bits; `None` for a number, whose width is that of the format.
    pub width: Option<u32>,
}

/// The ports of a bundle's values, in order.
///
/// ```
/// use raypath_ops::{Binary32, RayTriangleOutput, ports_of};
///
/// let ports = ports_of::<RayTriangleOutput<Binary32>>();
/// assert_eq!(ports[2].name, "triangle_hit");
/// assert_eq!((ports[0].width, ports[2].width), (None, Some(1)));
/// ```
pub fn ports_of<B: Bundle<Binary32>>() -> Vec<Port> {
    let mut source = Shapes(Vec::new());
    B::build(&mut Path::default(), &mut source);
    source.0
}

/// Replaces the contents of `words` by a bundle's port values: one word per port, in the order of [`ports_of`]. Numbers
/// keep their bits, including the payloads of NaNs.
pub fn to_words<C: Concrete>(bundle: &impl Bundle<C>, words: &mut Vec<u64>) {
    words.clear();
    bundle.each(&mut Path::unnamed(), &mut ToWords::new(words, C::raw_bits));
}

/// As [`to_words`], but every NaN becomes the canonical NaN, as in the results of a datapath.
pub fn to_canonical_words<C: Concrete>(bundle: &impl Bundle<C>, words: &mut Vec<u64>) {
    words.clear();
    bundle.each(&mut Path::unnamed(), &mut ToWords::new(words, C::bits));
}

/// The bundle with these port values, as of [`ports_of`]. Missing words are 0; bits beyond a port's width are ignored.
pub fn from_words<C: Concrete, B: Bundle<C>>(circuit: C, words: &[u64]) -> B {
    B::build(&mut Path::unnamed(), &mut FromWords::new(circuit, words, C::number))
}

pub(crate) struct Shapes(pub Vec<Port>);

impl Shapes {
    fn push(&mut self, field: &Field<'_>, kind: PortKind, width: Option<u32>) {
        self.0.push(Port { name: field.name.to_string(), kind, width });
    }
}

impl Source<Binary32> for Shapes {
    fn num(&mut self, field: Field<'_>) -> Num<Binary32> {
        self.push(&field, PortKind::Number, None);
        0.0.into()
    }
    fn bit(&mut self, field: Field<'_>) -> Bit<Binary32> {
        match field.bit {
            Some((index, _)) if index > 0 => {}
            of => self.push(&field, PortKind::Flags, Some(of.map_or(1, |(_, width)| width))),
        }
        false.into()
    }
    fn word(&mut self, field: Field<'_>, width: u32) -> (Binary32, u32) {
        self.push(&field, PortKind::Word, Some(width));
        (Binary32, 0)
    }
}

pub(crate) fn canonical<C: Concrete>(circuit: C, bits: u64) -> C::Num {
    circuit.number(circuit.bits(circuit.number(bits)))
}

pub(crate) struct ToWords<'w, C: Concrete> {
    words: &'w mut Vec<u64>,
    bits: fn(C, C::Num) -> u64,
}

impl<'w, C: Concrete> ToWords<'w, C> {
    #[inline]
    pub fn new(words: &'w mut Vec<u64>, bits: fn(C, C::Num) -> u64) -> Self {
        Self { words, bits }
    }
}

impl<C: Concrete> Sink<C> for ToWords<'_, C> {
    #[inline]
    fn num(&mut self, _: Field<'_>, value: Num<C>) {
        self.words.push((self.bits)(value.circuit, value.value));
    }
    #[inline]
    fn bit(&mut self, field: Field<'_>, value: Bit<C>) {
        let bit = u64::from(value.value);
        match (field.bit, self.words.last_mut()) {
            (Some((index, _)), Some(word)) if index > 0 => *word |= bit << index,
            _ => self.words.push(bit),
        }
    }
    #[inline]
    fn word(&mut self, _: Field<'_>, _width: u32, value: u32) {
        self.words.push(value.into());
    }
}

pub(crate) struct FromWords<'w, C: Concrete> {
    circuit: C,
    words: slice::Iter<'w, u64>,
    /// The word that was read last, whose bits are the elements of flags.
    last: u64,
    number: fn(C, u64) -> C::Num,
}

impl<'w, C: Concrete> FromWords<'w, C> {
    #[inline]
    pub fn new(circuit: C, words: &'w [u64], number: fn(C, u64) -> C::Num) -> Self {
        Self { circuit, words: words.iter(), last: 0, number }
    }

    #[inline]
    fn next(&mut self) -> u64 {
        self.words.next().copied().unwrap_or(0)
    }
}

impl<C: Concrete> Source<C> for FromWords<'_, C> {
    #[inline]
    fn num(&mut self, _: Field<'_>) -> Num<C> {
        let bits = self.next();
        Num::new(self.circuit, (self.number)(self.circuit, bits))
    }
    #[inline]
    fn bit(&mut self, field: Field<'_>) -> Bit<C> {
        let index = field.bit.map_or(0, |(index, _)| index);
        if index == 0 {
            self.last = self.next();
        }
        Bit::new(self.circuit, self.last >> index & 1 == 1)
    }
    #[inline]
    fn word(&mut self, _: Field<'_>, width: u32) -> (C, u32) {
        (self.circuit, self.next() as u32 & (u32::MAX >> (32 - width)))
    }
}
