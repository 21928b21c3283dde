//! A walk in a small simulation of time: what it issues is what searches compute, in the order that its pace says.

use raypath_model::Functional;
use raypath_ops::{JobKind, Outcome, Rules};
use raypath_search::{Clusters, Datapath, Graph, GraphParameters, Metric, Pace, Step, Walk};
use std::collections::VecDeque;

/// What a walk did.
#[derive(Debug, Default, PartialEq)]
struct Seen {
    fetches: usize,
    beats: usize,
    waits: usize,
    /// The most jobs that were in flight.
    flight: usize,
}

/// Runs a walk in a datapath that answers `latency` steps later.
fn run(walk: &mut Walk<'_>, latency: usize, kind: JobKind) -> Seen {
    let mut datapath = Functional::<16, 8>::new(Rules::Paper);
    let mut flying: VecDeque<Option<Outcome>> = vec![None; latency].into();
    let (mut seen, mut held) = (Seen::default(), false);
    loop {
        let step = walk.step();
        assert!(!held || matches!(step, Step::Issue { .. }), "beats of a vector go back to back");
        let mut entering = None;
        match step {
            Step::Fetch => seen.fetches += 1,
            Step::Issue { job, holds } => {
                assert_eq!(job.kind(), kind);
                held = holds;
                seen.beats += 1;
                entering = Some(datapath.run(&job));
            }
            Step::Wait => {
                assert!(flying.iter().any(Option::is_some), "there is something to wait for");
                seen.waits += 1;
            }
            Step::Done => {
                assert!(flying.iter().all(Option::is_none), "all has been answered");
                return seen;
            }
        }
        flying.push_back(entering);
        seen.flight = seen.flight.max(flying.iter().flatten().count());
        if let Some(outcome) = flying.pop_front().flatten() {
            walk.answer(&outcome);
        }
    }
}

#[test]
fn a_streaming_walk_is_exact_search() {
    let data = Clusters { vectors: 20, queries: 1, dimensions: 40, ..Clusters::default() }.generate().expect("data");
    let query = data.queries.get(0).expect("a query");
    for (metric, kind, beats) in
        [(Metric::Euclidean, JobKind::Euclidean, 20 * 3), (Metric::Angular, JobKind::Angular, 21 * 5)]
    {
        let candidates = (0..20).collect();
        let mut walk = Walk::new(&data.base, query, metric, candidates, Pace::streaming(8)).expect("a walk");
        let seen = run(&mut walk, 12, kind);
        assert_eq!(seen, Seen { fetches: 3, beats, waits: 12, flight: 13 }, "it waits at the end alone");

        let mut datapath = Datapath::<16, 8>::new();
        let expected = data.base.iter().map(|v| datapath.distance(metric, query, v).expect("a distance"));
        assert_eq!(walk.distances(), expected.collect::<Vec<_>>());
    }
}

#[test]
fn a_dependent_walk_waits_for_every_candidate() {
    let data = Clusters { vectors: 500, queries: 1, dimensions: 40, ..Clusters::default() }.generate().expect("data");
    let query = data.queries.get(0).expect("a query");
    let graph = Graph::<16, 8>::build(&data.base, Metric::Euclidean, &GraphParameters::default(), &|_| true);
    let log = graph.expect("a graph").log(query, 10, 20).expect("a log");
    let count = log.len();
    let mut walk = Walk::new(&data.base, query, Metric::Euclidean, log.clone(), Pace::DEPENDENT).expect("a walk");
    let seen = run(&mut walk, 12, JobKind::Euclidean);
    assert_eq!(seen, Seen { fetches: count, beats: 3 * count, waits: 12 * count, flight: 3 });
    let mut datapath = Datapath::<16, 8>::new();
    for (&index, &distance) in log.iter().zip(walk.distances()) {
        let candidate = data.base.get(index as usize).expect("a vector");
        assert_eq!(Ok(distance), datapath.distance(Metric::Euclidean, query, candidate));
    }
}

#[test]
fn impossible_walks_are_refused() {
    let data = Clusters { vectors: 20, queries: 1, dimensions: 4, ..Clusters::default() }.generate().expect("data");
    let error = |query: &[f32], candidates: Vec<u32>, batch: usize| {
        let walk = Walk::<16, 8>::new(&data.base, query, Metric::Euclidean, candidates, Pace::streaming(batch));
        walk.map(|_| ()).expect_err("refused").to_string()
    };
    assert_eq!(error(&[0.0; 3], vec![0], 1), "queries of 3 dimensions, expected 4 as the base has");
    assert_eq!(error(&[0.0; 4], vec![0, 20], 1), "candidate is 20, expected an index of the base");
    assert_eq!(error(&[0.0; 4], vec![0], 0), "batch is 0, expected at least 1");
    let mut empty = Walk::<16, 8>::new(&data.base, &[0.0; 4], Metric::Euclidean, Vec::new(), Pace::DEPENDENT);
    assert_eq!(empty.as_mut().map(Walk::step), Ok(Step::Done));
}
