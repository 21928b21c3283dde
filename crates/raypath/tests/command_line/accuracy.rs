//! The accuracy of formats: errors counted by hand, bounds on rounding errors, and changes that must not affect
//! results.

use crate::command_line::ends_with;
use raypath::float::Format;
use raypath::ops::Rules;
use raypath_cli::accuracy::{Accuracy, Errors, Quantiles, Quantity, RAYS, Row};

const FP32: Accuracy = Accuracy { format: Format::BINARY32, rules: Rules::Paper, scale: 1.0 };

#[test]
fn errors_are_counted_in_ulps_of_the_format() {
    let mut errors = Errors::default();
    assert_eq!(errors.quantiles(), None);
    // An ulp of binary16 is 2^-10 from 1 to 2, 2^-11 from 0.5 to 1, and 2^-24 near zero.
    let half = Format::BINARY16;
    for step in (0..200).rev() {
        errors.add(half, Some(1.0 + f64::from(step) / 1024.0), Some(1.0));
    }
    assert_eq!(errors.quantiles(), Some(Quantiles { median: 99.0, percentile_99: 197.0, max: 199.0 }));
    errors.add(half, Some(-0.5), Some(0.75));
    errors.add(half, Some(0.0), Some(2.0_f64.powi(-14)));
    let Some(Quantiles { max, .. }) = errors.quantiles() else { panic!("errors") };
    assert_eq!(max, 2560.0);
    assert_eq!((errors.results, errors.hits, errors.disagreements, errors.not_finite), (202, 202, 0, 0));
}

#[test]
fn hits_misses_and_non_numbers() {
    let mut errors = Errors::default();
    for (result, reference) in [
        (Some(1.0), Some(1.0)),
        (None, Some(1.0)),
        (Some(1.0), None),
        (None, None),
        (Some(f64::NAN), Some(1.0)),
        (Some(f64::INFINITY), Some(1.0)),
        (Some(f64::INFINITY), Some(f64::INFINITY)),
    ] {
        errors.add(Format::TF32, result, reference);
    }
    assert_eq!((errors.results, errors.hits, errors.disagreements, errors.not_finite), (7, 5, 2, 2));
    assert_eq!(errors.quantiles(), Some(Quantiles { median: 0.0, percentile_99: 0.0, max: 0.0 }));
}

/// The error of a result with n roundings and no cancellation is at most n ulps, with a margin of 5 %. The inputs are
/// those rounded to the format.
#[test]
fn errors_obey_their_bounds() {
    for format in [Format::BINARY32, Format::TF32, Format::BFLOAT16, Format::BINARY16] {
        let rows = Accuracy { format, ..FP32 }.random_jobs(3, 3_000, || true);
        // Roundings: a difference and a product; a difference that counts twice, a square, four levels of a tree and
        // three further beats; a square, three levels and seven further beats.
        for (quantity, roundings) in [(Quantity::BoxEntry, 2.0), (Quantity::EuclideanSum, 10.0), (Quantity::Norm, 11.0)]
        {
            let Some(Quantiles { median, max, .. }) = of(&rows, quantity).on_rounded.quantiles() else {
                panic!("errors")
            };
            assert!(max <= roundings * 1.05, "{format} {quantity}: {max}");
            assert!(median > 0.2 && median < max, "{format} {quantity}: {median}");
        }
        // The rounding of the inputs adds to the error.
        let entry = of(&rows, Quantity::BoxEntry);
        let median = |errors: &Errors| errors.quantiles().map(|quantiles| quantiles.median);
        assert!(median(&entry.on_original) > median(&entry.on_rounded), "{format}");
    }
}

/// A wider exponent has no effect if all numbers are in the range.
#[test]
fn the_range_matters_only_on_overflow_and_underflow() {
    let wide = |significand| Format::new(11, significand).expect("a format");
    for format in [Format::BINARY32, Format::TF32, Format::BFLOAT16] {
        let accuracy = |format| Accuracy { format, ..FP32 }.random_jobs(4, 1_000, || true);
        same(&accuracy(wide(format.significand())), &accuracy(format));
    }
    // Squares of 64 dimensions at 64 times the size are beyond 65504.
    let rows = Accuracy { format: Format::BINARY16, scale: 64.0, ..FP32 }.random_jobs(4, 100, || true);
    let sums = &of(&rows, Quantity::EuclideanSum).on_original;
    assert_eq!((sums.results, sums.not_finite, sums.quantiles()), (100, 100, None));
}

/// Scaling by a power of two changes no significand.
#[test]
fn scale_by_a_power_of_two_changes_no_error() {
    for scale in [1024.0, 1.0 / 1024.0] {
        let scaled = Accuracy { scale, ..FP32 };
        same(&scaled.random_jobs(5, 1_000, || true), &FP32.random_jobs(5, 1_000, || true));
    }
}

#[test]
fn a_scene_is_measured_in_pixels() {
    let rows = FP32.scene(|| true);
    let [boxes, triangles, pixels] =
        [Quantity::BoxEntry, Quantity::TriangleDistance, Quantity::Pixel].map(|quantity| of(&rows, quantity));
    assert_eq!(pixels.on_original.results, RAYS);
    let (entered, hits, seen) = (boxes.on_original.hits, triangles.on_original.hits, pixels.on_original.hits);
    assert!(RAYS / 4 < seen && seen <= hits && hits < entered && entered <= triangles.on_original.results);
    // Significands of 24 bits hit the same pixels as 53 bits; significands of 8 bits do not.
    assert_eq!(pixels.on_original.disagreements, 0);
    let mut left = RAYS / 2;
    let rows = Accuracy { format: Format::BFLOAT16, ..FP32 }.scene(|| {
        left -= 1;
        left > 0
    });
    assert!(of(&rows, Quantity::Pixel).on_original.disagreements > 0);
}

#[test]
fn a_measurement_can_be_stopped() {
    let mut left = 10;
    let mut watch = || {
        left -= 1;
        left > 0
    };
    let rows = FP32.random_jobs(6, 1_000, &mut watch);
    assert_eq!(of(&rows, Quantity::Norm).on_original.results, 10);
    assert_eq!(of(&rows, Quantity::BoxEntry).on_original.results, 40);
    left = 20;
    let rows = FP32.scene(|| {
        left -= 1;
        left > 0
    });
    assert_eq!(of(&rows, Quantity::Pixel).on_original.results, 20);
}

#[test]
fn wrong_input_is_named() {
    let cases: [(&[&str], &[&str]); 6] = [
        (&["--rules", "bounds"], &["'bounds'", "--rules", "expected paper or chisel"]),
        (&["--format", "fp16,fp8"], &["'fp8' is not a valid format", "fp32, tf32, bf16, fp16 or eXsY"]),
        (&["--format", "e4s8"], &["'e4s8'", "significand of 8 bits, expected 3 to 7 for an exponent of 4 bits"]),
        (&["--scale", "0"], &["'0'", "expected a number from 1e-30 to 1e30"]),
        (&["--scale", "much"], &["'much'", "expected a number from 1e-30 to 1e30"]),
        (&["--jobs", "0"], &["'0'", "--jobs", "expected a whole number from 1 to 1000000"]),
    ];
    for (arguments, words) in cases {
        ends_with(&[&["accuracy"], arguments].concat(), 2, words);
    }
}

fn of(rows: &[Row], quantity: Quantity) -> &Row {
    rows.iter().find(|row| row.quantity == quantity).expect("a row")
}

fn same(found: &[Row], expected: &[Row]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!(found.on_rounded == expected.on_rounded, "{}, rounded", found.quantity);
        assert!(found.on_original == expected.on_original, "{}, original", found.quantity);
    }
}
