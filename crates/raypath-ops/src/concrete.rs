use crate::circuit::Circuit;

/// A circuit whose values are known, so that numbers have bits: native arithmetic or soft float.
pub trait Concrete: Circuit<Bit = bool, Word = u32> {
    /// The number with these bits in IEEE 754's layout; bits beyond the format's width are ignored.
    fn number(self, ieee_bits: u64) -> Self::Num;

    /// Its bits in IEEE 754's layout; every NaN is the canonical one.
    fn bits(self, number: Self::Num) -> u64;

    /// Its bits as they are: of a NaN that came in by [`number`](Self::number), sign and payload too.
    fn raw_bits(self, number: Self::Num) -> u64;
}
