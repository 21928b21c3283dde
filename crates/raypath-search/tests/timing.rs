//! The cycle-exact simulation does a search's work, no more and no less, and finds what it finds.

use raypath_model::{Control, Loop, PipelinePosition, Shape};
use raypath_ops::JobKind;
use raypath_search::{
    Candidates, Clusters, Dataset, Exact, Graph, GraphParameters, Log, Metric, SearchError, Subject, TimingError,
    Vectors, Walk, Work, sweep_search, time_search,
};
use raypath_timing::{Cycle, Hardware, Machine, Observer, Sample, SimulationError, Sink, Timing};
use std::num::NonZeroUsize;

fn machines() -> [Hardware; 5] {
    let machine = |in_flight, memory_latency, sink| Machine { in_flight, memory_latency, sink };
    let stalls = Sink::Stalls { probability: 0.3, seed: 1 };
    let slow_sums = vec![
        Loop { opcode: JobKind::Euclidean.opcode(), first: 6, last: 9 },
        Loop { opcode: JobKind::Angular.opcode(), first: 6, last: 8 },
    ];
    [
        Hardware::default(),
        Hardware { machine: machine(1, 0, Sink::Always), ..Hardware::default() },
        Hardware {
            machine: machine(300, 17, Sink::Always),
            shape: Shape { control: Control::Credit, latency: 20, ..Shape::default() },
        },
        Hardware { machine: machine(8, 40, stalls), ..Hardware::default() },
        Hardware { machine: machine(5, 9, stalls), shape: Shape { loops: slow_sums, ..Shape::default() } },
    ]
}

fn clusters(vectors: usize, queries: usize, dimensions: usize) -> Dataset {
    Clusters { vectors, queries, dimensions, clusters: 9, ..Clusters::default() }.generate().expect("data")
}

fn does_the_work_of(timing: &Timing, work: Work, metric: Metric, queries: usize) {
    let (kind, norms) = match metric {
        Metric::Euclidean => (JobKind::Euclidean, 0),
        Metric::Angular => (JobKind::Angular, queries as u64),
    };
    assert_eq!((timing.jobs_of(kind), timing.all_jobs()), (work.beats, work.beats));
    // A query's own norm takes its beats, but the query is there.
    assert_eq!(timing.fetches, work.evaluations - norms);
    assert_eq!(timing.agents, queries as u64);
}

#[test]
fn exact_search_finds_what_it_finds() {
    exact::<16, 8>(&[1, 7, 16, 20, 33]);
    exact::<8, 4>(&[3, 20]);
}

fn exact<const E: usize, const A: usize>(dimensions: &[usize]) {
    for &dimensions in dimensions {
        let Dataset { base, queries, .. } = clusters(70, 13, dimensions);
        for metric in Metric::ALL {
            let expected = Exact::<E, A>::new(&base, metric).search(&queries, 6, &|_| true).expect("answers");
            let candidates = Candidates::All { count: 6 };
            let subject = Subject { base: &base, queries: &queries, metric, candidates };
            assert_eq!(subject.work::<E, A>(Sample::ALL), expected.work);
            for hardware in machines() {
                let timed = time_search::<E, A>(&subject, Sample::ALL, &hardware, &mut (), &|_| true);
                let (timing, rows) = timed.expect("a timing");
                assert_eq!(rows, expected.rows, "{metric}, {dimensions} dimensions");
                does_the_work_of(&timing, expected.work, metric, 13);
            }
        }
    }
}

#[test]
fn a_graph_finds_what_it_finds() {
    let Dataset { base, queries, .. } = clusters(600, 25, 20);
    for metric in Metric::ALL {
        let graph = Graph::<16, 8>::build(&base, metric, &GraphParameters::default(), &|_| true).expect("a graph");
        for (count, ef) in [(5, 5), (10, 40), (1, 1)] {
            let expected = graph.search(&queries, count, ef, &|_| true).expect("answers");
            let logs = graph.logs(&queries, count, ef, u64::MAX, &|_| true).expect("logs");
            let subject = Subject { base: &base, queries: &queries, metric, candidates: Candidates::Logged(&logs) };
            assert_eq!(subject.work::<16, 8>(Sample::ALL), expected.work);
            for hardware in machines() {
                let timed = time_search::<16, 8>(&subject, Sample::ALL, &hardware, &mut (), &|_| true);
                let (timing, rows) = timed.expect("a timing");
                assert_eq!(rows, expected.rows, "{metric}, {count} of {ef}");
                does_the_work_of(&timing, expected.work, metric, 25);
            }
        }
    }
}

/// A fetch takes 100 cycles, a beat one, and the last answer comes 12 later and is taken in one more: in the last cycle.
#[test]
fn cycles_are_those_of_a_count_by_hand() {
    // Two Euclidean beats, three angular ones.
    let Dataset { base, queries, .. } = clusters(3, 2, 20);
    let log = Log { candidates: vec![0, 1, 2], found: vec![0] };
    let logs = [log.clone(), log];
    let time = |metric, candidates, in_flight, memory_latency| {
        let machine = Machine { in_flight, memory_latency, ..Machine::default() };
        let hardware = Hardware { machine, ..Hardware::default() };
        let subject = Subject { base: &base, queries: &queries, metric, candidates };
        time_search::<16, 8>(&subject, Sample::ALL, &hardware, &mut (), &|_| true).expect("a timing").0.cycles
    };
    let (all, logged) = (Candidates::All { count: 1 }, Candidates::Logged(&logs));
    assert_eq!(time(Metric::Euclidean, all, 1, 100), 2 * (3 * (100 + 2) + 12));
    assert_eq!(time(Metric::Euclidean, logged, 1, 100), 2 * 3 * (100 + 2 + 12));
    // The query's norm comes first; nothing waits for it.
    assert_eq!(time(Metric::Angular, all, 1, 100), 2 * (3 + 3 * (100 + 3) + 12));
    assert_eq!(time(Metric::Angular, logged, 1, 100), 2 * (3 + 3 * (100 + 3 + 12)));
    // Both at once: the second query's beats follow those of the first.
    assert_eq!(time(Metric::Euclidean, all, 2, 100), 3 * (100 + 2) + 2 + 12);
    assert_eq!(time(Metric::Euclidean, logged, 2, 100), 3 * (100 + 2 + 12) + 2);
    // Memory that costs nothing: a beat in every cycle.
    assert_eq!(time(Metric::Euclidean, all, 2, 0), 2 * 3 * 2 + 12);
}

/// Sees whose jobs are accepted.
#[derive(Default)]
struct Owners(Vec<u64>);

impl Observer for Owners {
    fn wants(&self, cycle: u64) -> Option<u64> {
        Some(cycle)
    }
    fn cycle(&mut self, cycle: &Cycle, _: impl Iterator<Item = PipelinePosition>) {
        self.0.extend(cycle.offered.filter(|_| cycle.accepted).map(|(_, owner)| owner));
    }
}

#[test]
fn beats_of_a_vector_follow_each_other() {
    // Three beats a vector.
    let Dataset { base, queries, .. } = clusters(20, 9, 40);
    let candidates = Candidates::All { count: 1 };
    let subject = Subject { base: &base, queries: &queries, metric: Metric::Euclidean, candidates };
    for hardware in machines() {
        let mut owners = Owners::default();
        time_search::<16, 8>(&subject, Sample::ALL, &hardware, &mut owners, &|_| true).expect("a timing");
        assert_eq!(owners.0.len(), 9 * 20 * 3);
        assert!(owners.0.as_chunks::<3>().0.iter().all(|[a, b, c]| a == b && b == c));
        let turns = owners.0.windows(2).filter(|pair| pair[0] != pair[1]).count();
        // Alone one query follows another; otherwise they take turns, vector by vector.
        assert!(if hardware.machine.in_flight == 1 { turns == 8 } else { turns > 100 }, "{turns}");
    }
}

#[test]
fn samples_are_bounded_by_beats() {
    let Dataset { base, queries, .. } = clusters(50, 12, 40);
    let candidates = Candidates::All { count: 2 };
    let subject = Subject { base: &base, queries: &queries, metric: Metric::Angular, candidates };
    // 51 vectors of 5 beats.
    let within = |beats| subject.within::<16, 8>(beats).numbers(subject.len()).len();
    assert_eq!([0, 254, 255, 509, 510, u64::MAX].map(within), [0, 0, 1, 1, 2, 12]);
    assert_eq!(subject.work::<16, 8>(subject.within::<16, 8>(600)), Work { evaluations: 102, beats: 510 });

    let graph = Graph::<16, 8>::build(&base, Metric::Angular, &GraphParameters::default(), &|_| true).expect("a graph");
    let all = graph.logs(&queries, 2, 4, u64::MAX, &|_| true).expect("logs");
    let logged = |logs| Subject { candidates: Candidates::Logged(logs), ..subject };
    let five = logged(&all).work::<16, 8>(Sample::first(5)).beats;
    for (beats, count) in [(five - 1, 4), (five, 5), (five + 1, 5)] {
        assert_eq!(graph.logs(&queries, 2, 4, beats, &|_| true).expect("logs"), all[..count]);
        assert_eq!(logged(&all).within::<16, 8>(beats), Sample::first(count));
    }
    assert_eq!((logged(&all[..5]).len(), logged(&[]).is_empty()), (5, true));

    let sample = Sample { every: NonZeroUsize::new(4).expect("four"), most: 2 };
    let expected = graph.search(&queries, 2, 4, &|_| true).expect("answers").rows;
    let timed = time_search::<16, 8>(&logged(&all), sample, &Hardware::default(), &mut (), &|_| true);
    assert_eq!(timed.expect("a timing").1, [expected[0].clone(), expected[4].clone()]);
    let none = time_search::<16, 8>(&logged(&[]), Sample::ALL, &Hardware::default(), &mut (), &|_| true);
    assert_eq!(none, Ok((Timing::default(), Vec::new())));
}

#[test]
fn sweeps_are_many_timings() {
    let Dataset { base, queries, .. } = clusters(50, 20, 40);
    let candidates = Candidates::All { count: 1 };
    let subject = Subject { base: &base, queries: &queries, metric: Metric::Angular, candidates };
    let (sample, hardware) = (Sample::first(15), Hardware::default());
    let (in_flight, latencies) = ([1, 4, 16], [0, 100]);
    let sweep = sweep_search::<16, 8>(&subject, sample, &in_flight, &latencies, &hardware, &|_| true).expect("a sweep");
    assert_eq!(sweep.points.len(), 6);
    for point in sweep.points {
        let hardware = Hardware { machine: point.machine, ..Hardware::default() };
        let timed = time_search::<16, 8>(&subject, sample, &hardware, &mut (), &|_| true).expect("a timing");
        assert_eq!(point.timing, timed.0);
    }
}

#[test]
fn what_cannot_be_timed_is_refused() {
    let Dataset { base, queries, .. } = clusters(3000, 60, 4);
    let other = Vectors::new(3, vec![0.0; 3]).expect("a vector");
    let time = |queries, candidates, in_flight, watch| {
        let subject = Subject { base: &base, queries, metric: Metric::Euclidean, candidates };
        let hardware = Hardware { machine: Machine { in_flight, ..Machine::default() }, ..Hardware::default() };
        time_search::<16, 8>(&subject, Sample::ALL, &hardware, &mut (), watch).expect_err("refused")
    };
    let all = |count| Candidates::All { count };
    let neighbours = |asked| TimingError::Search(SearchError::Neighbours { asked, there: 3000 });
    assert_eq!(time(&queries, all(0), 1, &|_| true), neighbours(0));
    assert_eq!(time(&queries, all(3001), 1, &|_| true), neighbours(3001));
    let dimensions = TimingError::Search(SearchError::Dimensions { base: 4, queries: 3 });
    let logs = [Log { candidates: vec![0, 3000], found: vec![7] }];
    assert_eq!(time(&other, all(1), 1, &|_| true), dimensions);
    assert_eq!(time(&other, Candidates::Logged(&logs), 1, &|_| true), dimensions);
    let foreign = time(&queries, Candidates::Logged(&logs), 1, &|_| true).to_string();
    assert_eq!(foreign, "candidate is 3000, expected an index of the base");
    assert_eq!(time(&queries, all(1), 0, &|_| true), TimingError::Simulation(SimulationError::NoPlace));
    let stopped = time(&queries, all(1), 4, &|done| done < 20);
    assert!(matches!(stopped, TimingError::Simulation(SimulationError::Stopped { agents: 20.. })), "{stopped:?}");
    let query = queries.get(0).expect("a query");
    let logged = Log { candidates: vec![1], found: vec![2] };
    let walk = Walk::logged(&base, query, Metric::Euclidean, &logged).expect("a walk");
    assert_eq!(walk.into_neighbours(), [], "nothing has been answered");
}
