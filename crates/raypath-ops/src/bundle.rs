//! Structures of numbers, bits and words with named fields. Ports, registers and file columns follow from the
//! structure.

use crate::{Bit, Circuit, Flags, Num, Word};
use std::fmt::{Arguments, Write};

/// A structure of values of circuit `C`. Implemented for [`Num`], [`Bit`], [`Word`], [`Flags`], arrays, `()`, and for
/// structures that are declared with [`bundle!`](crate::bundle).
pub trait Bundle<C: Circuit>: Copy {
    /// Builds the structure from the values that `source` returns for its leaves, in the order of declaration.
    fn build<S: Source<C> + ?Sized>(path: &mut Path, source: &mut S) -> Self;
    /// Passes every leaf to `sink`, in the same order.
    fn each<S: Sink<C> + ?Sized>(&self, path: &mut Path, sink: &mut S);
}

/// The position of a leaf in its structure, which determines its port.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Field<'p> {
    /// The field names from the root to the leaf, joined with underscores: `ray_origin_x`.
    pub name: &'p str,
    /// For an element of [`Flags`]: the bit of the port, and the port's width.
    pub bit: Option<(u32, u32)>,
}

/// A source of a bundle's values.
pub trait Source<C: Circuit> {
    /// Returns a number.
    fn num(&mut self, field: Field<'_>) -> Num<C>;
    /// Returns a truth value.
    fn bit(&mut self, field: Field<'_>) -> Bit<C>;
    /// Returns a word of `width` bits.
    fn word(&mut self, field: Field<'_>, width: u32) -> (C, C::Word);
}

/// A receiver of a bundle's values.
pub trait Sink<C: Circuit> {
    /// Receives a number.
    fn num(&mut self, field: Field<'_>, value: Num<C>);
    /// Receives a truth value.
    fn bit(&mut self, field: Field<'_>, value: Bit<C>);
    /// Receives a word of `width` bits.
    fn word(&mut self, field: Field<'_>, width: u32, value: C::Word);
}

/// The field names from the root of a bundle to a leaf.
#[derive(Debug, Default)]
pub struct Path {
    name: String,
    is_unnamed: bool,
}

impl Path {
    /// A path that begins with `name`, which may be empty.
    pub fn new(name: &str) -> Self {
        Self { name: name.to_string(), is_unnamed: false }
    }

    /// A path without names, for sources and sinks that identify leaves by their order; it is faster.
    pub fn unnamed() -> Self {
        Self { name: String::new(), is_unnamed: true }
    }

    /// Appends a segment. Pass the result to [`leave`](Self::leave) to remove it.
    // Does not call `enter_number`: there are thousands of calls, and each level would be compiled for each.
    #[inline]
    pub fn enter(&mut self, segment: &str) -> usize {
        if self.is_unnamed { 0 } else { self.append(format_args!("{segment}")) }
    }

    /// Appends a number as [`enter`](Self::enter) appends a name.
    #[inline]
    pub fn enter_number(&mut self, segment: usize) -> usize {
        if self.is_unnamed { 0 } else { self.append(format_args!("{segment}")) }
    }

    /// Removes the segment that was appended last.
    #[inline]
    pub fn leave(&mut self, entered: usize) {
        self.name.truncate(entered);
    }

    #[inline(never)]
    fn append(&mut self, segment: Arguments<'_>) -> usize {
        let length = self.name.len();
        if length > 0 {
            self.name.push('_');
        }
        // Writing to a String cannot fail.
        let _ = write!(self.name, "{segment}");
        length
    }

    fn field(&self) -> Field<'_> {
        Field { name: &self.name, bit: None }
    }
}

impl<C: Circuit> Bundle<C> for Num<C> {
    fn build<S: Source<C> + ?Sized>(path: &mut Path, source: &mut S) -> Self {
        source.num(path.field())
    }
    fn each<S: Sink<C> + ?Sized>(&self, path: &mut Path, sink: &mut S) {
        sink.num(path.field(), *self);
    }
}

impl<C: Circuit> Bundle<C> for Bit<C> {
    fn build<S: Source<C> + ?Sized>(path: &mut Path, source: &mut S) -> Self {
        source.bit(path.field())
    }
    fn each<S: Sink<C> + ?Sized>(&self, path: &mut Path, sink: &mut S) {
        sink.bit(path.field(), *self);
    }
}

impl<C: Circuit, const W: u32> Bundle<C> for Word<C, W> {
    fn build<S: Source<C> + ?Sized>(path: &mut Path, source: &mut S) -> Self {
        const { assert!(W >= 1 && W <= 32, "a word has 1 to 32 bits") };
        let (circuit, value) = source.word(path.field(), W);
        Self::new(circuit, value)
    }
    fn each<S: Sink<C> + ?Sized>(&self, path: &mut Path, sink: &mut S) {
        sink.word(path.field(), W, self.value);
    }
}

impl<C: Circuit, const N: usize> Bundle<C> for Flags<C, N> {
    fn build<S: Source<C> + ?Sized>(path: &mut Path, source: &mut S) -> Self {
        const { assert!(N >= 1 && N <= 64, "a port of flags has 1 to 64 bits") };
        Self(std::array::from_fn(|i| source.bit(Field { name: &path.name, bit: Some((i as u32, N as u32)) })))
    }
    fn each<S: Sink<C> + ?Sized>(&self, path: &mut Path, sink: &mut S) {
        for (i, bit) in self.0.iter().enumerate() {
            sink.bit(Field { name: &path.name, bit: Some((i as u32, N as u32)) }, *bit);
        }
    }
}

impl<C: Circuit, B: Bundle<C>, const N: usize> Bundle<C> for [B; N] {
    fn build<S: Source<C> + ?Sized>(path: &mut Path, source: &mut S) -> Self {
        std::array::from_fn(|i| {
            let entered = path.enter_number(i);
            let element = B::build(path, source);
            path.leave(entered);
            element
        })
    }
    fn each<S: Sink<C> + ?Sized>(&self, path: &mut Path, sink: &mut S) {
        for (i, element) in self.iter().enumerate() {
            let entered = path.enter_number(i);
            element.each(path, sink);
            path.leave(entered);
        }
    }
}

impl<C: Circuit> Bundle<C> for () {
    fn build<S: Source<C> + ?Sized>(_: &mut Path, _: &mut S) -> Self {}
    fn each<S: Sink<C> + ?Sized>(&self, _: &mut Path, _: &mut S) {}
}
