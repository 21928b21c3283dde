//! Classes of numbers, and the operands that they are counted for.

use crate::layout::Field;
use raypath_float::Format;
use raypath_ops::Rules;
use raypath_rtl::Semantics;

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

/// The operand of an operation to which a field belongs; none for fields that are not read or are no numbers. Triangles
/// read no direction and inverse of a ray, and its extent for a range only. Boxes read no shear and axes, and the
/// direction with rules `chisel` only.
pub fn operand(operation: &str, semantics: Semantics, field: Field) -> Option<&'static str> {
    const VERTICES: [&str; 3] = ["vertex A", "vertex B", "vertex C"];
    match (operation, field) {
        ("triangle" | "quadbox" | "octbox" | "quantised_box" | "sphere", Field::Origin(_)) => Some("origin"),
        ("triangle", Field::Shear(_)) => Some("shear"),
        ("triangle", Field::Vertex { vertex, .. }) => VERTICES.get(vertex).copied(),
        ("triangle", Field::TMin) => Some("t_min"),
        ("triangle", Field::Extent) if !semantics.features.range => None,
        ("triangle" | "quadbox" | "octbox" | "quantised_box", Field::Extent) => Some("extent"),
        ("quadbox" | "octbox" | "quantised_box", Field::Inverse(_)) => Some("inverse"),
        ("quadbox", Field::Direction(_)) if semantics.rules != Rules::Chisel => None,
        ("quadbox" | "quantised_box" | "sphere", Field::Direction(_)) => Some("direction"),
        ("quadbox" | "octbox" | "point_in_box", Field::Bound { is_max, .. }) => {
            Some(if is_max { "box max" } else { "box min" })
        }
        ("euclidean" | "angular", Field::Lane { of_candidate, .. }) => {
            Some(if of_candidate { "candidate" } else { "query" })
        }
        (_, Field::NodeOrigin(_)) => Some("node origin"),
        (_, Field::NodeScale(_)) => Some("node scale"),
        (_, Field::Centre(_)) => Some("centre"),
        (_, Field::Radius) => Some("radius"),
        (_, Field::Point(_)) => Some("point"),
        (_, Field::Key) => Some("key"),
        (_, Field::Separator(_)) => Some("separator"),
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
