//! The numbers that a sample selects.

use raypath_timing::Sample;
use std::num::NonZeroUsize;

#[test]
fn samples_are_evenly_spread() {
    let numbers = |sample: Sample, count| sample.numbers(count).collect::<Vec<_>>();
    assert_eq!(numbers(Sample::ALL, 4), [0, 1, 2, 3]);
    assert_eq!(numbers(Sample::first(2), 4), [0, 1]);
    assert_eq!(numbers(Sample::first(2), 1), [0]);
    assert_eq!(numbers(Sample { stride: NonZeroUsize::new(3).expect("three"), max: 3 }, 20), [0, 3, 6]);
    assert_eq!(numbers(Sample::spread(10, 4), 10), [0, 3, 6, 9]);
    assert_eq!(numbers(Sample::spread(10, 0), 10), [0]);
    assert_eq!(numbers(Sample::spread(0, 4), 0), [0; 0]);
    assert_eq!(Sample::spread(1_201, 100).stride.get(), 13);
}
