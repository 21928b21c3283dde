//! Recall, the counts of results, and generated data.

use raypath_search::{
    Clusters, Exact, Metric, Neighbour, Neighbours, SearchError, SearchResults, Vectors, Work, recall,
};

/// Points on a line, and one query at 0.
fn line() -> (Vectors, Vectors) {
    let base = Vectors::new(1, vec![1.0, -1.0, 2.0, 3.0, 2.0, 9.0]).expect("vectors");
    (base, Vectors::new(1, vec![0.0]).expect("vectors"))
}

/// The recall at `count` of the indices `found` for the query on the line.
fn on_the_line(found: &[u32], truth: &[i64], count: usize) -> Result<f64, SearchError> {
    let (base, queries) = line();
    let distance = |index: u32| base.data()[index as usize].abs().into();
    let row = found.iter().map(|&index| Neighbour { index, distance: distance(index) }).collect();
    let results = SearchResults { rows: vec![row], work: Work::default(), seconds: 1.0 };
    let truth = Neighbours::new(truth.len(), truth, base.len()).expect("neighbours");
    recall(&results, &truth, &base, &queries, Metric::Euclidean, count)
}

#[test]
fn recall_of_small_cases() {
    assert_eq!(on_the_line(&[0, 1, 2], &[0, 1, 2], 3), Ok(1.0));
    assert_eq!(on_the_line(&[0, 1, 4], &[0, 1, 2], 3), Ok(1.0), "as far as the last");
    assert_eq!(on_the_line(&[0, 1, 3], &[0, 1, 2], 3), Ok(2.0 / 3.0));
    assert_eq!(on_the_line(&[3, 5], &[0, 1, 2], 3), Ok(0.0));
    assert_eq!(on_the_line(&[], &[0, 1, 2], 3), Ok(0.0));
    assert_eq!(on_the_line(&[0, 0, 0], &[0, 1, 2], 3), Ok(1.0 / 3.0), "found twice counts once");
    assert_eq!(on_the_line(&[1], &[0, 1, 2], 1), Ok(1.0), "as far as the first");
    assert_eq!(on_the_line(&[2, 0], &[0, 1, 2], 1), Ok(0.0), "beyond the first do not count");
}

#[test]
fn mismatched_truth_is_an_error() {
    let error = on_the_line(&[0], &[0, 1], 3).expect_err("an error").to_string();
    assert_eq!(error, "truth of 2 neighbours per query, expected 3");
    let (base, queries) = line();
    let truth = Neighbours::new(1, &[0, 1], base.len()).expect("neighbours");
    let results = SearchResults { rows: vec![Vec::new()], work: Work::default(), seconds: 1.0 };
    let error = recall(&results, &truth, &base, &queries, Metric::Euclidean, 1).expect_err("an error");
    assert_eq!(error.to_string(), "truth of 2 queries, expected 1");
    assert!(on_the_line(&[0], &[0], 0).is_err());
}

#[test]
fn results_have_means_per_query() {
    let rows = vec![Vec::new(); 4];
    let results = SearchResults { rows, work: Work { evaluations: 10, beats: 90 }, seconds: 0.5 };
    assert_eq!(results.queries_per_second(), 8.0);
    assert_eq!((results.per_query(results.work.evaluations), results.per_query(results.work.beats)), (2.5, 22.5));
    assert_eq!(Metric::ALL.map(|metric| metric.beats(130)), [9, 17]);
}

#[test]
fn exact_search_counts_its_beats() {
    let data = Clusters { vectors: 50, queries: 3, dimensions: 33, ..Clusters::default() }.generate().expect("data");
    let work = |metric| Exact::new(&data.base, metric).search(&data.queries, 1, &|_| true).expect("results").work;
    assert_eq!(work(Metric::Euclidean), Work { evaluations: 150, beats: 450 });
    assert_eq!(work(Metric::Angular), Work { evaluations: 153, beats: 153 * 5 });
}

#[test]
fn vectors_lie_in_their_clusters() {
    let clusters = Clusters { vectors: 4000, queries: 50, dimensions: 30, clusters: 7, spread: 0.1, seed: 3 };
    let data = clusters.generate().expect("data");
    assert_eq!((data.base.len(), data.queries.len(), data.base.dimensions()), (4000, 50, 30));
    assert_eq!(data, clusters.generate().expect("data"));
    assert_ne!(data, Clusters { seed: 4, ..clusters }.generate().expect("data"));

    // Two vectors of one cluster are at about spread · √(2 · dimensions) = 0.77, of different clusters at about √(2 ·
    // 30) = 7.7.
    let first = data.base.iter().next().expect("a vector");
    let squared = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f32>();
    let near: Vec<f32> = data.base.iter().map(|v| squared(first, v).sqrt()).filter(|&d| d < 2.0).collect();
    assert!((400..750).contains(&near.len()), "{} of 4000 share one of 7 clusters", near.len());
    let mean = near.iter().sum::<f32>() / near.len() as f32;
    assert!((0.6..0.95).contains(&mean), "{mean}");
    let beyond = data.base.iter().filter(|v| (2.0..4.0).contains(&squared(first, v).sqrt())).count();
    assert_eq!(beyond, 0, "no vector is between the clusters");
}

#[test]
fn invalid_clusters_are_errors() {
    let ok = Clusters::default();
    let error = |clusters: Clusters| clusters.generate().expect_err("an error").to_string();
    assert_eq!(error(Clusters { vectors: 0, ..ok }), "vectors is 0, expected at least 1, and 2^32 coordinates at most");
    assert!(error(Clusters { vectors: usize::MAX, ..ok }).starts_with("vectors is"));
    assert!(error(Clusters { queries: 0, ..ok }).starts_with("queries is 0"));
    assert!(error(Clusters { clusters: 0, ..ok }).starts_with("clusters is 0"));
    assert_eq!(error(Clusters { dimensions: 0, ..ok }), "dimensions is 0, expected 1 to 65536");
    assert_eq!(error(Clusters { spread: f32::NAN, ..ok }), "spread is NaN, expected 0 to 1000");
    assert_eq!(error(Clusters { spread: -1.0, ..ok }), "spread is -1, expected 0 to 1000");
}
