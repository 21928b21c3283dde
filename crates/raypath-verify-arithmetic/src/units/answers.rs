//! The expected results of dividers.

/// The results for operands a and b in IEEE 754's layout, with canonical NaNs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Answers {
    /// a / b.
    pub quotient: u64,
    /// 1 / b.
    pub reciprocal: u64,
    /// The square root of a.
    pub root: u64,
}
