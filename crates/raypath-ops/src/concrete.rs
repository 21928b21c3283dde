use crate::circuit::Circuit;

/// A circuit that computes values: native arithmetic or software floating point. Its numbers convert to and from bits.
pub trait Concrete: Circuit<Bit = bool, Word = u32> {
    /// The number with these bits in the IEEE 754 layout. Bits beyond the format's width are ignored.
    fn number(self, ieee_bits: u64) -> Self::Num;

    /// The number's bits in the IEEE 754 layout. Every NaN becomes the canonical NaN.
    fn bits(self, number: Self::Num) -> u64;

    /// The number's bits, including the sign and payload of a NaN that was made by [`number`](Self::number).
    fn raw_bits(self, number: Self::Num) -> u64;
}
