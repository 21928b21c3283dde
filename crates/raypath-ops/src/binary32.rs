//! Native binary32 arithmetic.

use crate::{Bit, Flags, Layout, Num, Word};
use std::fmt;

/// IEEE 754 binary32, computed by the floating-point instructions of the machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Binary32;

/// A binary32 number. Two are equal if their bits are; all NaNs are equal.
#[derive(Clone, Copy, Default)]
pub struct Single(pub f32);

crate::native_circuit!(Binary32, Single(f32), u32, Layout::BINARY32, 0x7fc0_0000);

impl fmt::Debug for Single {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:08x} ({:e})", self.to_bits(), self.0)
    }
}

impl From<f32> for Num<Binary32> {
    fn from(value: f32) -> Self {
        Num::new(Binary32, Single(value))
    }
}

impl From<Num<Binary32>> for f32 {
    fn from(number: Num<Binary32>) -> f32 {
        number.value.0
    }
}

impl Num<Binary32> {
    /// The number with these bits.
    pub fn from_bits(bits: u32) -> Self {
        f32::from_bits(bits).into()
    }

    /// The number's bits; a NaN becomes the canonical NaN.
    pub fn to_bits(self) -> u32 {
        self.value.to_bits()
    }
}

impl From<bool> for Bit<Binary32> {
    fn from(value: bool) -> Self {
        Bit::new(Binary32, value)
    }
}

impl From<Bit<Binary32>> for bool {
    fn from(bit: Bit<Binary32>) -> bool {
        bit.value
    }
}

impl<const W: u32> From<Word<Binary32, W>> for u32 {
    fn from(word: Word<Binary32, W>) -> u32 {
        word.value
    }
}

impl<const W: u32> Word<Binary32, W> {
    /// The low `W` bits of `value`.
    pub fn truncate(value: u32) -> Self {
        Word::new(Binary32, if W < 32 { value & ((1 << W) - 1) } else { value })
    }
}

impl<const N: usize> Flags<Binary32, N> {
    /// The flags of an array; element `i` is bit `i`.
    pub fn new(bits: [bool; N]) -> Self {
        Self(bits.map(Bit::from))
    }

    /// The flags of a mask; bit `i` is element `i`.
    pub fn from_mask(mask: u64) -> Self {
        Self(std::array::from_fn(|i| (mask >> i & 1 == 1).into()))
    }

    /// The flags as an array.
    pub fn to_array(self) -> [bool; N] {
        self.0.map(bool::from)
    }
}
