//! Valid formats, their names, and the recoded format of the specification.

use raypath_float::{Format, ParseFormatError};

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

/// With one more significand bit than the bound, the recoded exponent of the smallest subnormal would begin with 000.
#[test]
fn the_bound_is_where_the_smallest_subnormal_would_look_like_zero() {
    for e in 3..=6 {
        let most = (1 << (e - 2)) + 3;
        let format = Format::new(e, most).expect("the bound");
        assert_eq!(format.encode(1) >> format.fraction_width(), 0b001 << (e - 2), "{format}");
        assert_eq!(format.decode(format.encode(1)), 1);
        assert!(Format::new(e, most + 1).is_err());
    }
}

#[test]
fn messages_say_what_would_do() {
    let message = |e, s| Format::new(e, s).err().map(|error| error.to_string());
    let expected = "format with an exponent of 2 bits, expected 3 to 11";
    assert_eq!(message(2, 3).as_deref(), Some(expected));
    let expected = "format with a significand of 8 bits, expected 3 to 7 for an exponent of 4 bits";
    assert_eq!(message(4, 8).as_deref(), Some(expected));
}

#[test]
fn names() {
    for (name, widths, e, s) in
        [("fp32", "e8s24", 8, 24), ("tf32", "e8s11", 8, 11), ("bf16", "e8s8", 8, 8), ("fp16", "e5s11", 5, 11)]
    {
        let format = Format::new(e, s).expect("a format");
        assert_eq!((name.parse(), widths.parse()), (Ok(format), Ok(format)));
        assert_eq!((format.name(), format.to_string()), (name.to_string(), widths.to_string()));
    }
    let small: Format = "e5s3".parse().expect("a format");
    assert_eq!((small.exponent(), small.significand(), small.name()), (5, 3, "e5s3".to_string()));
}

#[test]
fn names_that_are_none() {
    for name in
        ["", "fp8", "FP16", "e8", "s8", "es", "e8s", "e+8s8", "e8s-3", "e8s8 ", "e8s99999999999", "e８s8", "8,24"]
    {
        assert_eq!(name.parse::<Format>(), Err(ParseFormatError::Name(name.to_string())));
    }
    let message = |name: &str| name.parse::<Format>().err().map(|error| error.to_string());
    let expected = "'half' is not a valid format, expected fp32, tf32, bf16, fp16 or eXsY: X exponent bits, \
         Y significand bits with the hidden one";
    assert_eq!(message("half").as_deref(), Some(expected));
    let expected = "'e4s8': format with a significand of 8 bits, expected 3 to 7 for an exponent of 4 bits";
    assert_eq!(message("e4s8").as_deref(), Some(expected));
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
    assert_eq!((format.infinity(), format.nan()), (0x7f80_0000, 0x7fc0_0000));
}
