//! Deliberate mistakes of the oracle: the comparisons must report each of them.

/// A deliberate mistake.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mistake {
    /// Ties round away from zero.
    TiesAway,
    /// Results have a bit less.
    ShortSignificand,
    /// Subnormal results are zero.
    FlushedSubnormals,
    /// Underflow is not reported.
    NoUnderflow,
    /// A sum that rounds once has no bits beyond its significand.
    ShortWindow,
    /// Inverses are not moved before they are narrowed.
    NoMargin,
    /// Touched boxes are missed by `paper`, and hit by `chisel`.
    StrictBoxes,
    /// Near and far are never exchanged.
    DirectionIgnored,
    /// Rays have no end.
    ExtentIgnored,
    /// Equal distances are in the reverse order of the indices.
    TiesReversed,
    /// Children are hit that are not used.
    UnusedChildren,
    /// Sums of three terms begin with the last two.
    OtherOrder,
    /// Edges belong to no triangle.
    OpenEdges,
    /// Both faces are hit.
    CullingIgnored,
    /// The ends of the range are not in it.
    OpenRange,
    /// All lanes count.
    MasksIgnored,
    /// Sums add neighbours first.
    Neighbours,
    /// A beat's reset does nothing.
    NeverRestarted,
    /// All beats use the first accumulator.
    OneAccumulator,
    /// A key that equals a separator is before it.
    StrictKeys,
    /// A point on a face is outside.
    OpenPoints,
    /// Spheres behind the ray are hit.
    SpheresBehind,
}
