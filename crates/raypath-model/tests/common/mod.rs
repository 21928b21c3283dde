//! Numbers for which operations have special rules.

/// Zeros, subnormals, ones and their neighbours, numbers whose squares leave the normal range, infinities and NaNs. The
/// last four are not finite.
pub const EDGES: [u32; 16] = [
    0x0000_0000, // 0
    0x8000_0000, // -0
    0x0000_0001, // smallest subnormal
    0x807f_ffff, // largest subnormal, negative
    0x0080_0000, // smallest normal
    0x3f80_0000, // 1
    0xbf80_0000, // -1
    0x3f80_0001, // 1 and an ulp
    0x4000_0000, // 2
    0x1a80_0000, // 2^-74: its square is subnormal
    0x5f80_0000, // 2^64: its square overflows
    0x7f7f_ffff, // largest
    0x7f80_0000, // infinity
    0xff80_0000, // -infinity
    0x7fc0_0000, // NaN
    0xffc0_1234, // NaN with sign and payload
];
