//! The cycle-exact simulation: neighbours, beats and fetches equal those of a search.

use crate::common::graph;
use raypath_model::{Control, Loop, Shape};
use raypath_ops::JobKind;
use raypath_search::{
    Candidates, Clusters, Dataset, Exact, LaneCount, Metric, QueryAgent, SearchError, SearchResults, SearchSpec,
    SearchTrace, TimingError, Vectors, Work, sweep_search, time_search,
};
use raypath_timing::report::Recorder;
use raypath_timing::{Environment, Sample, SimulationError, Sink, System, Timing};
use std::num::NonZeroUsize;

fn systems() -> [System; 5] {
    let environment = |in_flight, memory_latency, sink| Environment { in_flight, memory_latency, sink };
    let stalls = Sink::Stalls { probability: 0.3, seed: 1 };
    let slow_sums = vec![
        Loop { opcode: JobKind::Euclidean.opcode(), first: 6, last: 9 },
        Loop { opcode: JobKind::Angular.opcode(), first: 6, last: 8 },
    ];
    [
        System::default(),
        System { environment: environment(1, 0, Sink::Always), ..System::default() },
        System {
            environment: environment(300, 17, Sink::Always),
            shape: Shape { control: Control::Credit, latency: 20, ..Shape::default() },
        },
        System { environment: environment(8, 40, stalls), ..System::default() },
        System { environment: environment(5, 9, stalls), shape: Shape { loops: slow_sums, ..Shape::default() } },
    ]
}

/// A search with 16 lanes.
fn search<'s>(base: &'s Vectors, queries: &'s Vectors, metric: Metric, candidates: Candidates<'s>) -> SearchSpec<'s> {
    SearchSpec { base, queries, metric, lanes: LaneCount::Sixteen, candidates }
}

fn clusters(vectors: usize, queries: usize, dimensions: usize) -> Dataset {
    Clusters { vectors, queries, dimensions, clusters: 9, ..Clusters::default() }.generate().expect("data")
}

/// Checks that the simulation of a search has its results and its work in all systems.
fn assert_simulated(spec: &SearchSpec, expected: &SearchResults) {
    let (queries, work) = (expected.rows.len() as u64, expected.work);
    let (kind, norms) = match spec.metric {
        Metric::Euclidean => (JobKind::Euclidean, 0),
        Metric::Angular => (JobKind::Angular, queries),
    };
    assert_eq!(spec.work(Sample::ALL), work);
    for system in systems() {
        let timed = time_search(spec, Sample::ALL, &system, &mut (), &|_| true);
        let (timing, rows) = timed.expect("a timing");
        assert_eq!(rows, expected.rows, "{}, {} dimensions", spec.metric, spec.base.dimensions());
        assert_eq!((timing.jobs_of(kind), timing.total_jobs()), (work.beats, work.beats));
        // The norm of a query takes beats, but no fetch.
        assert_eq!(timing.fetches, work.evaluations - norms);
        assert_eq!(timing.agents, queries);
    }
}

#[test]
fn simulated_exact_search_finds_the_same() {
    exact(LaneCount::Sixteen, &[1, 7, 16, 20, 33]);
    exact(LaneCount::Eight, &[3, 20]);
}

fn exact(lanes: LaneCount, dimensions: &[usize]) {
    for &dimensions in dimensions {
        let Dataset { base, queries, .. } = clusters(70, 13, dimensions);
        for metric in Metric::ALL {
            let expected = Exact::new(&base, metric, lanes).search(&queries, 6, &|_| true).expect("results");
            let candidates = Candidates::All { count: 6 };
            let spec = SearchSpec { base: &base, queries: &queries, metric, lanes, candidates };
            assert_simulated(&spec, &expected);
        }
    }
}

#[test]
fn simulated_graph_search_finds_the_same() {
    let Dataset { base, queries, .. } = clusters(600, 25, 20);
    for metric in Metric::ALL {
        let graph = graph(&base, metric);
        for (count, ef) in [(5, 5), (10, 40), (1, 1)] {
            let expected = graph.search(&queries, count, ef, &|_| true).expect("results");
            let traces = graph.traces(&queries, count, ef, u64::MAX, &|_| true).expect("traces");
            assert_simulated(&search(&base, &queries, metric, Candidates::Traced(&traces)), &expected);
        }
    }
}

/// A fetch takes 100 cycles and a beat one; the last outcome leaves after 12 more.
#[test]
fn cycles_follow_from_the_latencies() {
    // Two Euclidean beats, three angular ones.
    let Dataset { base, queries, .. } = clusters(3, 2, 20);
    let trace = SearchTrace { candidates: vec![0, 1, 2], found: vec![0] };
    let traces = [trace.clone(), trace];
    let time = |metric, candidates, in_flight, memory_latency| {
        let environment = Environment { in_flight, memory_latency, ..Environment::default() };
        let system = System { environment, ..System::default() };
        let spec = search(&base, &queries, metric, candidates);
        time_search(&spec, Sample::ALL, &system, &mut (), &|_| true).expect("a timing").0.cycles
    };
    let (all, traced) = (Candidates::All { count: 1 }, Candidates::Traced(&traces));
    assert_eq!(time(Metric::Euclidean, all, 1, 100), 2 * (3 * (100 + 2) + 12));
    assert_eq!(time(Metric::Euclidean, traced, 1, 100), 2 * 3 * (100 + 2 + 12));
    // The norm of the query comes first, and no fetch waits for it.
    assert_eq!(time(Metric::Angular, all, 1, 100), 2 * (3 + 3 * (100 + 3) + 12));
    assert_eq!(time(Metric::Angular, traced, 1, 100), 2 * (3 + 3 * (100 + 3 + 12)));
    // With both in flight, the beats of the second query follow those of the first.
    assert_eq!(time(Metric::Euclidean, all, 2, 100), 3 * (100 + 2) + 2 + 12);
    assert_eq!(time(Metric::Euclidean, traced, 2, 100), 3 * (100 + 2 + 12) + 2);
    // With ideal memory, a beat enters in every cycle.
    assert_eq!(time(Metric::Euclidean, all, 2, 0), 2 * 3 * 2 + 12);
}

fn new_recorder() -> Recorder {
    Recorder::new("query", Shape::default().latency, 0, usize::MAX)
}

/// The owners of the recorded jobs, in the order of acceptance.
fn owners(recorder: Recorder) -> Vec<u64> {
    recorder.window().jobs.iter().map(|job| job.owner).collect()
}

#[test]
fn beats_of_a_vector_are_consecutive() {
    // Three beats a vector.
    let Dataset { base, queries, .. } = clusters(20, 9, 40);
    let spec = search(&base, &queries, Metric::Euclidean, Candidates::All { count: 1 });
    for system in systems() {
        let mut recorder = new_recorder();
        time_search(&spec, Sample::ALL, &system, &mut recorder, &|_| true).expect("a timing");
        let owners = owners(recorder);
        assert_eq!(owners.len(), 9 * 20 * 3);
        assert!(owners.as_chunks::<3>().0.iter().all(|[a, b, c]| a == b && b == c));
        let turns = owners.windows(2).filter(|pair| pair[0] != pair[1]).count();
        // A single query in flight finishes before the next; several take turns, vector by vector.
        assert!(if system.environment.in_flight == 1 { turns == 8 } else { turns > 100 }, "{turns}");
    }
}

#[test]
fn samples_are_limited_by_beats() {
    let Dataset { base, queries, .. } = clusters(50, 12, 40);
    let spec = search(&base, &queries, Metric::Angular, Candidates::All { count: 2 });
    // 51 vectors of 5 beats.
    let within = |beats| spec.within(beats).numbers(spec.len()).len();
    assert_eq!([0, 254, 255, 509, 510, u64::MAX].map(within), [0, 0, 1, 1, 2, 12]);
    assert_eq!(spec.work(spec.within(600)), Work { evaluations: 102, beats: 510 });

    let graph = graph(&base, Metric::Angular);
    let all = graph.traces(&queries, 2, 4, u64::MAX, &|_| true).expect("traces");
    let traced = |traces| SearchSpec { candidates: Candidates::Traced(traces), ..spec };
    let five = traced(&all).work(Sample::first(5)).beats;
    for (beats, count) in [(five - 1, 4), (five, 5), (five + 1, 5)] {
        assert_eq!(graph.traces(&queries, 2, 4, beats, &|_| true).expect("traces"), all[..count]);
        assert_eq!(traced(&all).within(beats), Sample::first(count));
    }
    assert_eq!((traced(&all[..5]).len(), traced(&[]).is_empty()), (5, true));

    let sample = Sample { stride: NonZeroUsize::new(4).expect("four"), max: 2 };
    let expected = graph.search(&queries, 2, 4, &|_| true).expect("results").rows;
    let timed = time_search(&traced(&all), sample, &System::default(), &mut (), &|_| true);
    assert_eq!(timed.expect("a timing").1, [expected[0].clone(), expected[4].clone()]);
    let none = time_search(&traced(&[]), Sample::ALL, &System::default(), &mut (), &|_| true);
    assert_eq!(none, Ok((Timing::default(), Vec::new())));
}

#[test]
fn sweep_points_equal_single_timings() {
    let Dataset { base, queries, .. } = clusters(50, 20, 40);
    let spec = search(&base, &queries, Metric::Angular, Candidates::All { count: 1 });
    let (sample, system) = (Sample::first(15), System::default());
    let (in_flight, latencies) = ([1, 4, 16], [0, 100]);
    let sweep = sweep_search(&spec, sample, &in_flight, &latencies, &system, &|_| true).expect("a sweep");
    assert_eq!(sweep.points.len(), 6);
    for point in sweep.points {
        let system = System { environment: point.environment, ..System::default() };
        let timed = time_search(&spec, sample, &system, &mut (), &|_| true).expect("a timing");
        assert_eq!(point.timing, timed.0);
    }
}

#[test]
fn invalid_simulations_are_errors() {
    let Dataset { base, queries, .. } = clusters(3000, 60, 4);
    let other = Vectors::new(3, vec![0.0; 3]).expect("a vector");
    let time = |queries, candidates, in_flight, progress| {
        let spec = search(&base, queries, Metric::Euclidean, candidates);
        let system = System { environment: Environment { in_flight, ..Environment::default() }, ..System::default() };
        time_search(&spec, Sample::ALL, &system, &mut (), progress).expect_err("an error")
    };
    let all = |count| Candidates::All { count };
    let neighbours = |requested| TimingError::Search(SearchError::Neighbours { requested, available: 3000 });
    assert_eq!(time(&queries, all(0), 1, &|_| true), neighbours(0));
    assert_eq!(time(&queries, all(3001), 1, &|_| true), neighbours(3001));
    let dimensions = TimingError::Search(SearchError::Dimensions { base: 4, queries: 3 });
    let traces = [SearchTrace { candidates: vec![0, 3000], found: vec![7] }];
    assert_eq!(time(&other, all(1), 1, &|_| true), dimensions);
    assert_eq!(time(&other, Candidates::Traced(&traces), 1, &|_| true), dimensions);
    let foreign = time(&queries, Candidates::Traced(&traces), 1, &|_| true).to_string();
    assert_eq!(foreign, "candidate is 3000, expected an index of the base");
    assert_eq!(time(&queries, all(1), 0, &|_| true), TimingError::Simulation(SimulationError::NoSlots));
    let stopped = time(&queries, all(1), 4, &|done| done < 20);
    assert!(matches!(stopped, TimingError::Simulation(SimulationError::Stopped { agents: 20.. })), "{stopped:?}");
    let query = queries.get(0).expect("a query");
    let trace = SearchTrace { candidates: vec![1], found: vec![2] };
    let agent = QueryAgent::traced(&base, query, Metric::Euclidean, &trace).expect("an agent");
    assert_eq!(agent.into_neighbours(), [], "no outcome was received");
}
