//! Distances of vectors of any dimension in the functional model, compared with integers.

use raypath_model::Functional;
use raypath_ops::{Beat, BeatInput, Binary32, Job, Outcome, Rules, VectorError};

/// Small integer coordinates, for which every sum is exact.
fn vector(dimensions: usize, seed: i32) -> Vec<f32> {
    (0..dimensions as i32).map(|i| ((i * 37 + seed * 101) % 19 - 9) as f32).collect()
}

fn sum_of(pairs: impl Iterator<Item = (i64, i64)>, term: impl Fn(i64, i64) -> i64) -> f32 {
    pairs.map(|(a, b)| term(a, b)).sum::<i64>() as f32
}

#[test]
fn distances_of_every_dimension() {
    let mut datapath = Functional::<16, 8>::new(Rules::Paper);
    for dimensions in 1..=100 {
        let (query, candidate) = (vector(dimensions, 1), vector(dimensions, dimensions as i32));
        let pairs = || query.iter().zip(&candidate).map(|(&a, &b)| (a as i64, b as i64));

        let beats = Beat::<Binary32, 16>::of(&query, &candidate).expect("beats");
        let jobs: Vec<Job> = beats.map(|euclidean| Job::Euclidean(BeatInput { euclidean })).collect();
        assert_eq!(jobs.len(), dimensions.div_ceil(16));
        let last = jobs.iter().map(|job| datapath.run(job)).last();
        let Some(Outcome::Euclidean(output)) = last else { panic!("{last:?}") };
        assert_eq!(f32::from(output.euclidean_accumulator), sum_of(pairs(), |a, b| (a - b) * (a - b)));
        assert!(bool::from(output.euclidean_reset_accum));

        let beats = Beat::<Binary32, 8>::of(&query, &candidate).expect("beats");
        let last = beats.map(|euclidean| datapath.run(&Job::Angular(BeatInput { euclidean }))).last();
        let Some(Outcome::Angular(output)) = last else { panic!("{last:?}") };
        assert_eq!(f32::from(output.angular_dot_product), sum_of(pairs(), |a, b| a * b));
        assert_eq!(f32::from(output.angular_norm), sum_of(pairs(), |_, b| b * b));
    }
}

#[test]
fn invalid_vectors_are_errors() {
    let error = |query: &[f32], candidate: &[f32]| Beat::<Binary32, 16>::of(query, candidate).err();
    assert_eq!(error(&[1.0; 3], &[1.0; 4]), Some(VectorError::Unequal { query: 3, candidate: 4 }));
    assert_eq!(error(&[], &[]), Some(VectorError::Empty));
    assert_eq!(error(&[], &[1.0]), Some(VectorError::Unequal { query: 0, candidate: 1 }));
}
