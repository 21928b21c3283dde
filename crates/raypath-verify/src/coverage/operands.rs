//! Classes of numbers, and the operands that they are counted for.

use crate::layout::Field;
use raypath_float::Format;
use raypath_ops::{JobKind, Rules};

/// The classes of a number.
pub const CLASSES: [&str; 12] =
    ["+0", "+subnormal", "+1", "+normal", "+∞", "−0", "−subnormal", "−1", "−normal", "−∞", "NaN", "NaN, not canonical"];

/// The class of a code, as a position in [`CLASSES`].
#[inline]
pub fn class(format: Format, code: u64) -> usize {
    let minus = 1 << (format.ieee_width() - 1);
    let magnitude = code & (minus - 1);
    let infinity = format.infinity();
    if magnitude > infinity {
        return if code == format.nan() { 10 } else { 11 };
    }
    let least_normal = 1 << format.fraction_width();
    let one = ((1 << (format.exponent() - 1)) - 1) << format.fraction_width();
    let of_magnitude = match magnitude {
        0 => 0,
        _ if magnitude < least_normal => 1,
        _ if magnitude == one => 2,
        _ if magnitude < infinity => 3,
        _ => 4,
    };
    5 * usize::from(code & minus != 0) + of_magnitude
}

/// The operands that an operation reads. Triangles read no direction, inverse or extent of a ray; boxes read no shear
/// and axes, and the direction with rules `chisel` only.
pub fn groups(kind: JobKind, rules: Rules) -> &'static [&'static str] {
    match (kind, rules) {
        (JobKind::Triangle, _) => &["origin", "shear", "vertex A", "vertex B", "vertex C"],
        (JobKind::Quadbox, Rules::Paper | Rules::Bounds(_)) => &["origin", "inverse", "extent", "box min", "box max"],
        (JobKind::Quadbox, Rules::Chisel) => &["origin", "inverse", "extent", "box min", "box max", "direction"],
        (JobKind::Euclidean | JobKind::Angular, _) => &["query", "candidate"],
    }
}

/// The position in [`groups`] of a field's operand; none for fields that are not read or are no numbers.
pub fn group(kind: JobKind, rules: Rules, field: Field) -> Option<usize> {
    match (kind, field) {
        (JobKind::Triangle | JobKind::Quadbox, Field::Origin(_)) => Some(0),
        (JobKind::Triangle, Field::Shear(_)) => Some(1),
        (JobKind::Triangle, Field::Vertex { vertex, .. }) => Some(2 + vertex),
        (JobKind::Quadbox, Field::Inverse(_)) => Some(1),
        (JobKind::Quadbox, Field::Extent) => Some(2),
        (JobKind::Quadbox, Field::Bound { is_max, .. }) => Some(3 + usize::from(is_max)),
        (JobKind::Quadbox, Field::Direction(_)) if rules == Rules::Chisel => Some(5),
        (JobKind::Euclidean | JobKind::Angular, Field::Lane { of_candidate, .. }) => Some(usize::from(of_candidate)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_are_those_of_ieee_754() {
        let of = |number: f32| CLASSES[class(Format::BINARY32, number.to_bits().into())];
        let numbers = [0.0, 1e-40, 1.0, 2.0, f32::INFINITY, -0.0, -1e-40, -1.0, -2.0, f32::NEG_INFINITY];
        assert_eq!(numbers.map(of), CLASSES[..10]);
        assert_eq!([f32::from_bits(0x7fc0_0000), f32::from_bits(0x7fc0_0001)].map(of), CLASSES[10..]);
        assert_eq!(
            [f32::MAX, f32::MIN_POSITIVE, f32::from_bits(0x007f_ffff)].map(of),
            ["+normal", "+normal", "+subnormal"]
        );
        assert_eq!(of(f32::from_bits(0xffc0_0000)), "NaN, not canonical");
    }
}
