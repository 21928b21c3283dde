//! Distances: the functional model against independent arithmetic, and searches against the functional model.

use crate::common::datapath::Datapath;
use rand::RngExt;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use raypath_model::levels;
use raypath_search::{Exact, Metric, SearchError, Vectors, cosine_distance, euclidean_distance};
use raypath_traversal::search::{dot_product, squared};
use std::sync::atomic::{AtomicU64, Ordering};

const U: f64 = 1.0 / 16_777_216.0;
/// The smallest subnormal number, 2^-149.
const MIN_SUBNORMAL: f64 = f32::from_bits(1) as f64;

/// γ of `docs/reference/error-bounds.md`.
fn gamma(roundings: u32) -> f64 {
    let k = f64::from(roundings) * U;
    k / (1.0 - k)
}

fn random(generator: &mut ChaCha8Rng, count: usize, scale: f32) -> Vec<f32> {
    (0..count).map(|_| scale * generator.random_range(-1.0..1.0f32)).collect()
}

/// Random numbers of all kinds: zeros, subnormal, normal and large numbers.
fn mixed(generator: &mut ChaCha8Rng, count: usize, large: f32) -> Vec<f32> {
    let number = |generator: &mut ChaCha8Rng| match generator.random_range(0..8) {
        0 => 0.0,
        1 => -0.0,
        2 => f32::from_bits(generator.random_range(0..0x80_0000)),
        3 => large * generator.random_range(-1.0..1.0f32),
        4 => 1e-22 * generator.random_range(-1.0..1.0f32),
        _ => generator.random_range(-1.0..1.0f32),
    };
    (0..count).map(|_| number(generator)).collect()
}

#[test]
fn model_distances_are_within_the_error_bound() {
    const E: usize = 16;
    const A: usize = 8;
    let mut generator = ChaCha8Rng::seed_from_u64(1);
    let mut datapath = Datapath::<E, A>::new();
    for dimensions in (1..=100).chain([255, 256, 1000]) {
        for scale in [1.0, 1e-21, 1e15] {
            let (query, candidate) =
                (random(&mut generator, dimensions, scale), random(&mut generator, dimensions, scale));
            let pairs = || query.iter().zip(&candidate).map(|(&a, &b)| (f64::from(a), f64::from(b)));
            let sum = |term: fn((f64, f64)) -> f64| pairs().map(term).sum::<f64>();
            let underflow = dimensions as f64 * MIN_SUBNORMAL;

            let beats = dimensions.div_ceil(E) as u32;
            let squared: f64 = sum(|(a, b)| (a - b) * (a - b));
            let bound = gamma(2 + E.ilog2() + beats) * squared + underflow;
            let ours = f64::from(datapath.squared(&query, &candidate));
            assert!((ours - squared).abs() <= bound, "{dimensions}: {ours} and {squared}");

            let roundings = A.ilog2() + dimensions.div_ceil(A) as u32;
            let [our_dot, our_norm] = datapath.angle(&query, &candidate);
            let (dot, magnitude, norm) = (sum(|(a, b)| a * b), sum(|(a, b)| (a * b).abs()), sum(|(_, b)| b * b));
            let (ours, bound) = (f64::from(our_dot), gamma(roundings) * magnitude + underflow);
            assert!((ours - dot).abs() <= bound, "{dimensions}: {ours} and {dot}");
            let (ours, bound) = (f64::from(our_norm), gamma(roundings) * norm + underflow);
            assert!((ours - norm).abs() <= bound, "{dimensions}: {ours} and {norm}");
        }
    }
}

#[test]
fn model_distances_of_small_integers_are_exact() {
    let mut generator = ChaCha8Rng::seed_from_u64(2);
    let mut datapath = Datapath::<16, 8>::new();
    let mut beats = 0;
    for dimensions in 1..=200usize {
        let integers = |generator: &mut ChaCha8Rng| -> Vec<i64> {
            (0..dimensions).map(|_| generator.random_range(-100..=100)).collect()
        };
        let (a, b) = (integers(&mut generator), integers(&mut generator));
        let float = |v: &[i64]| -> Vec<f32> { v.iter().map(|&x| x as f32).collect() };
        let sum = |term: fn(i64, i64) -> i64| a.iter().zip(&b).map(|(&a, &b)| term(a, b)).sum::<i64>() as f64;

        let squared = datapath.squared(&float(&a), &float(&b));
        assert_eq!(f64::from(squared), sum(|a, b| (a - b).pow(2)));
        let [dot, norm] = datapath.angle(&float(&a), &float(&b));
        assert_eq!(f64::from(dot), sum(|a, b| a * b));
        assert_eq!(f64::from(norm), sum(|_, b| b * b));
        beats += dimensions.div_ceil(16) + dimensions.div_ceil(8);
    }
    assert_eq!(datapath.beats, beats as u64);
}

#[test]
fn searches_have_the_bits_of_the_model() {
    const BASE: usize = 37;
    let mut generator = ChaCha8Rng::seed_from_u64(3);
    let mut datapath = Datapath::<16, 8>::new();
    let mut finite = 0;
    for dimensions in (1..=100).filter(|dimensions| dimensions % 3 == 1 || dimensions % 16 == 0) {
        for large in [1e3, 1e15, 1e19, f32::MAX] {
            let base = Vectors::new(dimensions, mixed(&mut generator, BASE * dimensions, large)).expect("vectors");
            let queries = Vectors::new(dimensions, mixed(&mut generator, 3 * dimensions, large)).expect("vectors");
            for metric in Metric::ALL {
                let search = |level| {
                    let exact = Exact::at(level, &base, metric);
                    exact.search(&queries, BASE, &|_| true).expect("results").rows
                };
                let rows = levels().into_iter().map(search).collect::<Vec<_>>();
                for (row, query) in rows.iter().flat_map(|rows| rows.iter().zip(queries.iter())) {
                    let mut expected: Vec<(f64, u32)> = base
                        .iter()
                        .zip(0..)
                        .map(|(candidate, index)| (datapath.distance(metric, query, candidate), index))
                        .collect();
                    expected.sort_by(|a, b| a.partial_cmp(b).expect("no NaN"));
                    let found: Vec<(f64, u32)> = row.iter().map(|near| (near.distance, near.index)).collect();
                    let bits = |row: &[(f64, u32)]| -> Vec<u64> { row.iter().map(|near| near.0.to_bits()).collect() };
                    assert_eq!(bits(&found), bits(&expected), "{metric}, {dimensions} dimensions");
                    assert_eq!(found, expected, "{metric}, {dimensions} dimensions");
                    finite += found.iter().filter(|(distance, _)| distance.is_finite()).count();
                }
            }
        }
    }
    assert!(finite > 30_000, "only {finite} distances are finite");
}

#[test]
fn plain_numbers_have_the_bits_of_the_operations() {
    let mut generator = ChaCha8Rng::seed_from_u64(7);
    let mut datapath = Datapath::<16, 8>::new();
    let mut compared = 0;
    for dimensions in (1..=70).chain([128, 1000]) {
        for large in [1e3, 1e15, 1e19, f32::MAX] {
            let [a, b] = [(); 2].map(|()| mixed(&mut generator, dimensions, large));
            let [dot, norm] = datapath.angle(&a, &b);
            let expected = [datapath.squared(&a, &b), dot, norm];
            let found = [squared(&a, &b), dot_product(&a, &b), dot_product(&b, &b)];
            for (found, expected) in found.into_iter().zip(expected) {
                assert!(found.to_bits() == expected.to_bits() || found.is_nan() && expected.is_nan(), "{dimensions}");
                compared += usize::from(!found.is_nan());
            }
        }
    }
    assert!(compared > 700, "{compared}");
}

#[test]
fn distances_follow_from_sums() {
    assert_eq!(euclidean_distance(2.0), 2f64.sqrt());
    assert_eq!(euclidean_distance(f32::INFINITY), f64::INFINITY);
    assert_eq!(cosine_distance(1.0, 2.0, 2.0), 0.5);
    assert_eq!(cosine_distance(-4.0, 2.0, 8.0), 2.0);
    assert_eq!(cosine_distance(f32::from_bits(0x3f80_0001), 1.0, 1.0), 0.0, "not negative");
    assert_eq!(cosine_distance(-1.1, 1.0, 1.0), 2.0, "not above 2");
    assert_eq!(cosine_distance(0.0, 0.0, 5.0), 1.0, "a zero query");
    assert_eq!(cosine_distance(0.0, 5.0, 0.0), 1.0, "a zero candidate");
    assert_eq!(cosine_distance(0.0, 0.0, 0.0), 1.0);
    for (dot, query, candidate) in
        [(f32::NAN, 1.0, 1.0), (f32::INFINITY, 1.0, 1.0), (0.0, f32::INFINITY, 0.0), (1.0, 1.0, f32::INFINITY)]
    {
        assert_eq!(cosine_distance(dot, query, candidate), f64::INFINITY, "an overflow is ordered last");
    }
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let mut generator = ChaCha8Rng::seed_from_u64(4);
    let base = Vectors::new(5, random(&mut generator, 5 * 5000, 1.0)).expect("vectors");
    let queries = Vectors::new(5, random(&mut generator, 5 * 100, 1.0)).expect("vectors");
    let exact = Exact::new(&base, Metric::Euclidean);
    let rows = [1, 2, 7].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| exact.search(&queries, 17, &|_| true).expect("results").rows)
    });
    assert_eq!(rows[0], rows[1]);
    assert_eq!(rows[0], rows[2]);
}

#[test]
fn progress_counts_queries() {
    let mut generator = ChaCha8Rng::seed_from_u64(5);
    let base = Vectors::new(64, random(&mut generator, 64 * 9000, 1.0)).expect("vectors");
    let queries = Vectors::new(64, random(&mut generator, 64 * 77, 1.0)).expect("vectors");
    let (calls, max) = (AtomicU64::new(0), AtomicU64::new(0));
    let progress = |done: u64| {
        calls.fetch_add(1, Ordering::Relaxed);
        max.fetch_max(done, Ordering::Relaxed) <= 77
    };
    Exact::new(&base, Metric::Euclidean).search(&queries, 1, &progress).expect("results");
    assert_eq!(max.into_inner(), 77);
    assert!(calls.into_inner() > 30, "progress is also polled within a group of queries");
}

#[test]
fn invalid_searches_are_errors() {
    let vectors = |dimensions: usize| Vectors::new(dimensions, vec![0.0; 3 * dimensions]).expect("vectors");
    let exact = Exact::new(&vectors(4), Metric::Euclidean);
    let error = |queries: usize, count: usize| exact.search(&vectors(queries), count, &|_| true).expect_err("an error");
    assert_eq!(error(5, 1), SearchError::Dimensions { base: 4, queries: 5 });
    assert_eq!(error(4, 0), SearchError::Neighbours { requested: 0, available: 3 });
    assert_eq!(error(4, 4).to_string(), "4 neighbours requested, expected 1 to 3, the number of vectors in the base");
    assert_eq!(exact.search(&vectors(4), 1, &|_| false), Err(SearchError::Stopped));
}
