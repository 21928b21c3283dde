//! What is a format and what is not.

use raypath_float::Format;

#[test]
fn bounds() {
    assert_eq!(Format::new(8, 24), Ok(Format::BINARY32));
    for (e, s) in [(3, 3), (3, 5), (4, 7), (5, 11), (6, 19), (7, 24), (11, 24), (11, 3)] {
        assert!(Format::new(e, s).is_ok(), "{e}, {s}");
    }
    for (e, s) in [(0, 0), (2, 3), (12, 24), (u32::MAX, 3), (8, 2), (8, 25), (8, u32::MAX), (3, 6), (4, 8), (5, 12)] {
        assert!(Format::new(e, s).is_err(), "{e}, {s}");
    }
}

#[test]
fn messages_say_what_would_do() {
    let message = |e, s| Format::new(e, s).err().map(|error| error.to_string());
    let expected = "format with an exponent of 2 bits, expected 3 to 11";
    assert_eq!(message(2, 3).as_deref(), Some(expected));
    let expected = "format with a significand of 8 bits, expected 3 to 7 where the exponent has 4";
    assert_eq!(message(4, 8).as_deref(), Some(expected));
}

#[test]
fn binary32_as_the_specification_lists_it() {
    let format = Format::BINARY32;
    assert_eq!((format.ieee_width(), format.recoded_width(), format.to_string()), (32, 33, "e8s24".to_string()));
    let exponent = |number: f32| format.encode(number.to_bits().into()) >> 23 & 0x1ff;
    assert_eq!(exponent(1.0), 0x100);
    assert_eq!(exponent(f32::from_bits(1)), 0x06b);
    assert_eq!(exponent(f32::MAX), 0x17f);
    assert_eq!(exponent(0.0), 0);
    assert_eq!(format.encode(f32::INFINITY.to_bits().into()), format.recoded_infinity());
    assert_eq!(format.recoded_infinity(), 0x180 << 23);
    assert_eq!(format.encode(0xffc0_1234), format.recoded_nan());
    assert_eq!(format.recoded_nan(), 0x1c0 << 23 | 1 << 22);
}
