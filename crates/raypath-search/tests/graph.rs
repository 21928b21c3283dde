//! Graph search: its recall on the digits, and its reproducibility.

use crate::common::datapath::Datapath;
use crate::common::{digits, graph, vectors};
use raypath_search::{
    Clusters, Exact, Graph, GraphParameters, LaneCount, Metric, Neighbours, SearchError, Vectors, recall,
};

const COUNT: usize = 10;
const EF: usize = 50;

fn base_and_queries() -> (Vectors, Vectors) {
    let digits = digits();
    (vectors(digits.iter().step_by(2)), vectors(digits.iter().step_by(18)))
}

fn truth(base: &Vectors, queries: &Vectors, metric: Metric) -> Neighbours {
    let exact = Exact::new(base, metric, LaneCount::Sixteen).search(queries, COUNT, &|_| true).expect("results");
    let indices: Vec<i64> = exact.rows.iter().flatten().map(|near| near.index.into()).collect();
    Neighbours::new(COUNT, &indices, base.len()).expect("neighbours")
}

#[test]
fn recall_is_high_on_digits() {
    let (base, queries) = base_and_queries();
    for metric in Metric::ALL {
        let graph = graph(&base, metric);
        let truth = truth(&base, &queries, metric);
        let mut last = 0;
        for (ef, floor) in [(10, 0.99), (EF, 0.999), (400, 0.999)] {
            let results = graph.search(&queries, COUNT, ef, &|_| true).expect("results");
            assert!(
                results.rows.iter().all(|row| row.len() == COUNT && row.is_sorted_by(|a, b| a.distance <= b.distance))
            );
            let recall = recall(&results, &truth, &base, &queries, metric, LaneCount::Sixteen, COUNT).expect("recall");
            let evaluations = results.per_query(results.work.evaluations);
            println!("{metric}, ef {ef}: recall {recall}, {evaluations} evaluations per query");
            assert!((floor..=1.0).contains(&recall), "{metric}, ef {ef}: recall {recall}");

            // A greater ef evaluates more vectors, but never all.
            assert!(results.work.evaluations > last);
            assert!(results.work.evaluations < (queries.len() * base.len()) as u64);
            last = results.work.evaluations;
            let beats = if metric == Metric::Euclidean { 4 } else { 8 };
            assert_eq!(results.work.beats, beats * results.work.evaluations);
            assert_eq!(Metric::ALL.map(|metric| metric.beats(LaneCount::Sixteen, base.dimensions())), [4, 8]);
        }
        assert!(graph.build_work().evaluations > base.len() as u64);
    }
}

#[test]
fn distances_have_the_bits_of_the_datapath() {
    for dimensions in [1, 7, 8, 16, 37, 64] {
        let clusters = Clusters { vectors: 300, queries: 10, dimensions, ..Clusters::default() };
        let data = clusters.generate().expect("data");
        for metric in Metric::ALL {
            let results = graph(&data.base, metric).search(&data.queries, COUNT, EF, &|_| true).expect("results");
            let mut datapath = Datapath::<16, 8>::new();
            for (query, row) in data.queries.iter().zip(&results.rows) {
                for near in row {
                    let candidate = data.base.get(near.index as usize).expect("a vector");
                    let expected = datapath.distance(metric, query, candidate);
                    assert_eq!(near.distance.to_bits(), expected.to_bits(), "{metric}, {dimensions} dimensions");
                }
            }
        }
    }
}

#[test]
fn equal_seeds_give_equal_graphs() {
    let (base, queries) = base_and_queries();
    let rows = |seed: u64, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let parameters = GraphParameters { connections: 4, ef_construction: 10, seed };
            let graph =
                Graph::build(&base, Metric::Angular, LaneCount::Sixteen, &parameters, &|_| true).expect("a graph");
            let results = graph.search(&queries, COUNT, COUNT, &|_| true).expect("results");
            (graph.build_work(), results.work, results.rows)
        })
    };
    assert_eq!(rows(1, 1), rows(1, 3));
    assert_ne!(rows(1, 1), rows(2, 1));
}

#[test]
fn graphs_of_few_and_of_equal_vectors_work() {
    for count in [1, 2, 5] {
        let base = Vectors::new(2, (0..2 * count).map(|i| i as f32).collect()).expect("vectors");
        let results = graph(&base, Metric::Euclidean).search(&base, count, count, &|_| true).expect("results");
        assert!(results.rows.iter().enumerate().all(|(i, row)| row.len() == count && row[0].index as usize == i));
    }
    // Zero vectors and sums that overflow give no NaN and no panic.
    for coordinate in [0.0, 1.0, f32::MAX] {
        let base = Vectors::new(3, vec![coordinate; 3 * 100]).expect("vectors");
        for metric in Metric::ALL {
            let results = graph(&base, metric).search(&base, 3, 10, &|_| true).expect("results");
            assert_eq!(results.rows.len(), 100);
        }
    }
}

#[test]
fn invalid_graphs_are_errors() {
    let base = Vectors::new(2, vec![0.0; 20]).expect("vectors");
    let build = |connections: usize, ef_construction: usize| {
        let parameters = GraphParameters { connections, ef_construction, seed: 1 };
        Graph::build(&base, Metric::Euclidean, LaneCount::Sixteen, &parameters, &|_| true)
            .map(|_| ())
            .map_err(|e| e.to_string())
    };
    assert_eq!(build(1, 10), Err("connections is 1, expected 2 to 255".to_owned()));
    assert_eq!(build(256, 10), Err("connections is 256, expected 2 to 255".to_owned()));
    assert_eq!(build(8, 0), Err("ef_construction is 0, expected 1 to 65536".to_owned()));
    assert_eq!(build(2, 1), Ok(()));
    assert_eq!(build(255, 1), Ok(()));
    let parameters = GraphParameters::default();
    let stopped = Graph::build(&base, Metric::Euclidean, LaneCount::Sixteen, &parameters, &|done| done < 5).map(|_| ());
    assert_eq!(stopped, Err(SearchError::Stopped));
    let graph = graph(&base, Metric::Euclidean);
    assert_eq!(graph.search(&base, 1, 1, &|_| false), Err(SearchError::Stopped));
    let error = graph.search(&base, 5, 4, &|_| true).expect_err("an error").to_string();
    assert_eq!(error, "ef is 4, expected at least the number of neighbours and at most 65536");
    assert!(graph.search(&base, 11, 20, &|_| true).is_err());
}
