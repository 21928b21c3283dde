//! Graphs: the unit's recall on the digits, their reproducibility, and small ones.

use crate::common::{digits, vectors};
use raypath_search::{
    Exact, GraphParameters, Layer, Metric, Neighbours, SearchError, StoredAs, UnitJobs, UnitPlace, UnitSpec, Vectors,
    recall,
};
use raypath_traversal::search::SearchParameters;

const COUNT: usize = 10;

fn layer(base: &Vectors, metric: Metric) -> Layer {
    Layer::build(base, metric, &GraphParameters::default(), &|_| true).expect("a graph").0
}

/// What the unit finds in a graph, with so many candidates.
fn search(base: &Vectors, queries: &Vectors, metric: Metric, layer: &Layer, [count, candidates]: [usize; 2]) -> Found {
    let elements = StoredAs::Binary32.elements([base, queries]);
    let jobs = UnitJobs::new(&UnitSpec {
        base,
        queries,
        metric: metric.into(),
        elements,
        neighbours: count,
        bound: f32::INFINITY,
        place: UnitPlace::Graph(layer, candidates),
        unit: SearchParameters::MOST,
    });
    let found = jobs.expect("jobs").search(&|_| true).expect("a search");
    let exact = Exact::new(base, metric).search(queries, count, &|_| true).expect("results");
    let indices: Vec<i64> = exact.rows.iter().flatten().map(|near| near.index.into()).collect();
    let truth = Neighbours::new(count, &indices, base.len()).expect("neighbours");
    let results = found.results(metric);
    let recall = recall(&results, &truth, base, queries, metric, count).expect("recall");
    Found { rows: results.rows.iter().map(Vec::len).collect(), recall, evaluations: found.work.evaluations }
}

struct Found {
    rows: Vec<usize>,
    recall: f64,
    evaluations: u64,
}

#[test]
fn recall_is_high_on_digits() {
    let digits = digits();
    let (base, queries) = (vectors(digits.iter().step_by(2)), vectors(digits.iter().step_by(18)));
    for metric in Metric::ALL {
        let layer = layer(&base, metric);
        let mut last = 0;
        for (candidates, floor) in [(10, 0.97), (50, 0.998), (250, 0.998)] {
            let Found { rows, recall, evaluations } = search(&base, &queries, metric, &layer, [COUNT, candidates]);
            assert!(rows.iter().all(|row| *row == COUNT));
            assert!((floor..=1.0).contains(&recall), "{metric}, {candidates} candidates: recall {recall}");
            // More candidates compare more vectors, but never all.
            assert!(evaluations > last && evaluations < (queries.len() * base.len()) as u64);
            last = evaluations;
        }
    }
}

#[test]
fn equal_seeds_give_equal_graphs() {
    let base = vectors(digits().iter().step_by(2));
    let build = |seed: u64| {
        let parameters = GraphParameters { connections: 4, ef_construction: 10, seed };
        Layer::build(&base, Metric::Angular, &parameters, &|_| true).expect("a graph")
    };
    assert_eq!(build(1), build(1));
    assert_ne!(build(1).0, build(2).0);
    assert!(build(1).1.evaluations > base.len() as u64);
}

#[test]
fn graphs_of_few_and_of_equal_vectors_work() {
    for count in [1, 2, 5] {
        let base = Vectors::new(2, (0..2 * count).map(|i| i as f32).collect()).expect("vectors");
        let layer = layer(&base, Metric::Euclidean);
        let found = search(&base, &base, Metric::Euclidean, &layer, [count, count]);
        assert_eq!((found.rows, found.recall), (vec![count; count], 1.0));
    }
    // Zero vectors and sums that overflow give no panic.
    for coordinate in [0.0, 1.0, f32::MAX] {
        let base = Vectors::new(3, vec![coordinate; 3 * 100]).expect("vectors");
        for metric in Metric::ALL {
            assert_eq!(search(&base, &base, metric, &layer(&base, metric), [3, 10]).rows.len(), 100);
        }
    }
}

#[test]
fn invalid_graphs_are_errors() {
    let base = Vectors::new(2, vec![0.0; 20]).expect("vectors");
    let build = |connections: usize, ef_construction: usize| {
        let parameters = GraphParameters { connections, ef_construction, seed: 1 };
        Layer::build(&base, Metric::Euclidean, &parameters, &|_| true).map(|_| ()).map_err(|e| e.to_string())
    };
    assert_eq!(build(1, 10), Err("connections is 1, expected 2 to 255".to_owned()));
    assert_eq!(build(256, 10), Err("connections is 256, expected 2 to 255".to_owned()));
    assert_eq!(build(8, 0), Err("ef_construction is 0, expected 1 to 65536".to_owned()));
    assert_eq!(build(2, 1), Ok(()));
    assert_eq!(build(255, 1), Ok(()));
    let stopped = Layer::build(&base, Metric::Euclidean, &GraphParameters::default(), &|done| done < 5).map(|_| ());
    assert_eq!(stopped, Err(SearchError::Stopped));
    let refused = |degree, neighbours, entry| Layer::new(degree, neighbours, entry).expect_err("refused").to_string();
    assert_eq!(refused(0, vec![Vec::new()], 0), "0 neighbours of a vector, expected 1 to 65535");
    assert_eq!(refused(1, vec![vec![0, 0]], 0), "vector 0: 2 neighbours, expected at most 1");
    assert_eq!(refused(1, vec![vec![1]], 0), "vector 0: neighbour 1, expected one of 1 vectors");
    assert_eq!(refused(1, vec![Vec::new()], 1), "the search begins with vector 1, expected one of 1");
}
