//! Numbers at the limits of a format.

use raypath_float::Format;

/// Numbers for which operations have special rules, and their neighbours: zeros, subnormals, ones, numbers whose
/// squares leave the normal range, infinities and NaN.
pub fn edges(format: Format) -> [u64; 16] {
    let last_place = 1;
    let power = |exponent: i64| (bias(format) + exponent).unsigned_abs() << format.fraction_width();
    let minus = 1 << (format.ieee_width() - 1);
    let least_normal = power(1 - bias(format));
    let largest = format.infinity() - last_place;
    [
        0,
        minus,
        last_place, // the smallest subnormal
        minus | (least_normal - last_place),
        least_normal,
        power(0),
        minus | power(0),
        power(0) + last_place,
        power(-1),
        power(1),
        power((1 - bias(format)) / 2) - last_place, // its square is subnormal
        power(bias(format) / 2),                    // its square is near the largest number
        largest,
        format.infinity(),
        minus | format.infinity(),
        format.nan(),
    ]
}

fn bias(format: Format) -> i64 {
    (1 << (format.exponent() - 1)) - 1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Expected values were written by hand.
    #[test]
    fn edges_are_those_of_the_format() {
        let binary32 = [
            0x0000_0000,
            0x8000_0000,
            0x0000_0001,
            0x807f_ffff,
            0x0080_0000,
            0x3f80_0000,
            0xbf80_0000,
            0x3f80_0001,
            0x3f00_0000,
            0x4000_0000,
            0x1fff_ffff,
            0x5f00_0000,
            0x7f7f_ffff,
            0x7f80_0000,
            0xff80_0000,
            0x7fc0_0000,
        ];
        assert_eq!(edges(Format::BINARY32), binary32);
        let binary16 = [
            0x0000, 0x8000, 0x0001, 0x83ff, 0x0400, 0x3c00, 0xbc00, 0x3c01, 0x3800, 0x4000, 0x1fff, 0x5800, 0x7bff,
            0x7c00, 0xfc00, 0x7e00,
        ];
        assert_eq!(edges(Format::BINARY16), binary16);
    }
}
