//! Exact search on a real data set, against integer arithmetic and scikit-learn. Pixels of the digits are integers from
//! 0 to 16, so binary32 represents every sum, and ties are exact.

use crate::common::{PIXELS, digits, unzip_text, vectors};
use raypath_search::{Exact, Metric};
use std::cmp::Ordering;

const COUNT: usize = 10;

/// Every ninth digit is a query, as in the oracle.
fn queries() -> impl Iterator<Item = usize> {
    (0..digits().len()).step_by(9)
}

/// The indices that exact search finds for each query.
fn found(metric: Metric) -> Vec<Vec<usize>> {
    let digits = digits();
    let queries = vectors(queries().map(|query| &digits[query]));
    let results = Exact::new(&vectors(&digits), metric).search(&queries, COUNT, &|_| true).expect("results");
    results.rows.iter().map(|row| row.iter().map(|near| near.index as usize).collect()).collect()
}

/// The indices that scikit-learn finds for each query.
fn oracle(metric: &str) -> Vec<Vec<usize>> {
    let text = unzip_text(include_bytes!("data/digits_neighbours.txt.gz"));
    let lines = text.lines().filter_map(|line| line.strip_prefix(metric));
    let rows: Vec<Vec<usize>> =
        lines.map(|line| line.split_whitespace().map(|number| number.parse().expect("an index")).collect()).collect();
    assert!(rows.iter().map(|row| row[0]).eq(queries()));
    rows.into_iter().map(|row| row[1..].to_vec()).collect()
}

fn squared(a: &[u8; PIXELS], b: &[u8; PIXELS]) -> i64 {
    a.iter().zip(b).map(|(&a, &b)| (i64::from(a) - i64::from(b)).pow(2)).sum()
}

fn dot(a: &[u8; PIXELS], b: &[u8; PIXELS]) -> u128 {
    a.iter().zip(b).map(|(&a, &b)| u128::from(a) * u128::from(b)).sum()
}

/// The exact order of two candidates by their distances from `query`. Dot products of digits are not negative, so the
/// order of cosines is that of their squares, as fractions.
fn order(metric: Metric, [query, a, b]: [&[u8; PIXELS]; 3]) -> Ordering {
    match metric {
        Metric::Euclidean => squared(query, a).cmp(&squared(query, b)),
        Metric::Angular => (dot(query, b).pow(2) * dot(a, a)).cmp(&(dot(query, a).pow(2) * dot(b, b))),
    }
}

#[test]
fn neighbours_equal_those_of_integer_arithmetic() {
    let digits = digits();
    for metric in Metric::ALL {
        // Sorting all digits takes most of the time.
        for (query, row) in queries().zip(found(metric)).step_by(3) {
            let mut all: Vec<usize> = (0..digits.len()).collect();
            all.sort_by(|&a, &b| order(metric, [query, a, b].map(|index| &digits[index])).then(a.cmp(&b)));
            assert_eq!(row, all[..COUNT], "{metric}, query {query}");
        }
    }
}

/// At every rank both vectors are equally far, and most are equal.
#[test]
fn neighbours_equal_those_of_scikit_learn_up_to_ties() {
    let digits = digits();
    for (name, metric) in [("euclidean", Metric::Euclidean), ("cosine", Metric::Angular)] {
        let mut same = 0;
        for ((query, ours), theirs) in queries().zip(found(metric)).zip(oracle(name)) {
            assert_eq!((ours.len(), theirs.len()), (COUNT, COUNT));
            assert_eq!(ours[0], query, "a digit is its own nearest neighbour");
            for (&a, &b) in ours.iter().zip(&theirs) {
                let order = order(metric, [query, a, b].map(|index| &digits[index]));
                assert_eq!(order, Ordering::Equal, "{name}, query {query}: {ours:?} and {theirs:?}");
                same += usize::from(a == b);
            }
        }
        assert!(same > 1900, "{name}: only {same} of 2000 are the same vector");
    }
}
