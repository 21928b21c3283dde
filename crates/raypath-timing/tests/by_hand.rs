//! Runs whose cycles are known from paper, and agents that come to no end.

mod common;

use common::{Echo, Script, echo, issue};
use raypath_model::{Control, Loop, Shape};
use raypath_ops::JobKind::{Angular, Euclidean, Quadbox, Triangle};
use raypath_timing::{Machine, Observer, SimulationError, Sink, Starved, Step, Timing, simulate};
use std::cell::Cell;

fn run(agents: Vec<Vec<Step<common::Tag>>>, machine: &Machine, shape: &Shape) -> Result<Timing, SimulationError> {
    simulate(agents.into_iter().map(Script::<Echo>::new), machine, echo(shape), &mut (), &|_| true)
}

fn machine(in_flight: usize, memory_latency: u64) -> Machine {
    Machine { in_flight, memory_latency, sink: Sink::Always }
}

fn shapes() -> impl Iterator<Item = Shape> {
    [Control::Skid, Control::Credit]
        .into_iter()
        .flat_map(|control| [1, 2, 12, 30].map(|latency| Shape { latency, control, loops: Vec::new() }))
}

/// One after another, nothing overlaps: each job costs the pipeline's latency and the cycle in which it is taken, each
/// fetch the memory's.
#[test]
fn one_agent_in_flight_takes_the_sum_of_all_latencies() {
    for shape in shapes() {
        let visit =
            [Step::Fetch, issue(Quadbox, 0), Step::Wait, Step::Fetch, Step::Fetch, issue(Triangle, 1), Step::Wait];
        let timing = run(vec![visit.to_vec(); 5], &machine(1, 70), &shape).expect("runs");
        let inside = shape.latency as u64;
        assert_eq!(
            timing,
            Timing {
                cycles: 5 * (3 * 70 + 2 * (inside + 1)),
                agents: 5,
                jobs: [5, 5, 0, 0],
                fetches: 15,
                accepted: 10,
                refused: 0,
                starved: Starved { memory: 5 * 3 * 70, answers: 10 * inside, both: 0, held: 0 },
                sink_refused: 0,
                inside: 10 * inside,
                queued: 0,
            }
        );
    }
}

/// A round is a fetch, a job and its answer: memory + latency + 1 cycles. R agents in step issue in R consecutive cycles
/// of each round as long as R is no more than that, and in every cycle if it is more.
#[test]
fn throughput_is_agents_over_the_length_of_a_round_until_it_is_one() {
    const ROUNDS: u64 = 50;
    for shape in shapes() {
        for memory in [1, 7, 60] {
            let round = memory + shape.latency as u64 + 1;
            for in_flight in [1, 2, 3, round - 1, round, round + 1, 2 * round] {
                let agent: Vec<_> = (0..ROUNDS).flat_map(|n| [Step::Fetch, issue(Quadbox, n), Step::Wait]).collect();
                let agents = vec![agent; in_flight as usize];
                let timing = run(agents, &machine(in_flight as usize, memory), &shape).expect("runs");
                // The first round's jobs leave one after another; from then on each is a round, or the queue, later.
                let expected = ROUNDS.saturating_sub(1) * round.max(in_flight) + round + in_flight - 1;
                assert_eq!(timing.cycles, expected, "{shape:?}, memory {memory}, {in_flight} in flight");
                assert_eq!(timing.accepted, ROUNDS * in_flight);
                assert_eq!(timing.accepted + timing.refused + timing.starved.total(), timing.cycles);
                let limit = (in_flight as f64 / round as f64).min(1.0);
                assert!((timing.jobs_per_cycle() / limit - 1.0).abs() < 0.05);
            }
        }
    }
}

/// Without memory and without waiting a job enters in every cycle, and the last one's answer is all that is waited for.
#[test]
fn jobs_that_depend_on_nothing_enter_in_every_cycle() {
    for shape in shapes() {
        let agents = vec![vec![issue(Quadbox, 0), issue(Triangle, 1), issue(Angular, 2)]; 40];
        for in_flight in [1, 2, 40] {
            let timing = run(agents.clone(), &machine(in_flight, 0), &shape).expect("runs");
            assert_eq!((timing.accepted, timing.inside), (120, 120 * shape.latency as u64));
            // One agent alone keeps its place until its answers have come.
            let rounds = if in_flight == 1 { 40 } else { 1 };
            if in_flight != 2 {
                assert_eq!(timing.cycles, 120 + rounds * (shape.latency as u64));
            }
        }
    }
}

#[test]
fn memory_that_costs_nothing_takes_no_cycle() {
    let agents = vec![vec![Step::Fetch, Step::Fetch, issue(Quadbox, 0), Step::Wait, Step::Fetch]; 3];
    let timing = run(agents, &machine(1, 0), &Shape::default()).expect("runs");
    assert_eq!((timing.cycles, timing.fetches), (3 * 13, 9));
}

#[test]
fn what_an_agent_does_last_counts() {
    let timing = run(vec![vec![issue(Quadbox, 0), Step::Fetch]; 2], &machine(1, 100), &Shape::default());
    // Accepted in cycle 0, then memory for 100; the answer comes meanwhile.
    assert_eq!(timing.expect("runs").cycles, 2 * 101);
    assert_eq!(run(vec![Vec::new(); 9], &machine(4, 100), &Shape::default()).map(|t| (t.cycles, t.agents)), Ok((0, 9)));
    assert_eq!(run(Vec::new(), &machine(4, 100), &Shape::default()).map(|t| (t.cycles, t.agents)), Ok((0, 0)));
}

/// An accumulator that takes four cycles lets a beat of its kind in every fourth.
#[test]
fn a_loop_in_the_pipeline_refuses_beats() {
    for control in [Control::Skid, Control::Credit] {
        let loops = vec![Loop { opcode: Euclidean.opcode(), first: 6, last: 9 }];
        let shape = Shape { latency: 12, control, loops };
        let beats = |kind| vec![(0..100).map(|n| issue(kind, n)).collect::<Vec<_>>()];
        let timing = run(beats(Euclidean), &machine(1, 0), &shape).expect("runs");
        assert_eq!(timing.cycles, 99 * 4 + 13, "{control:?}");
        assert_eq!(timing.accepted + timing.refused + timing.starved.total(), timing.cycles);
        assert!(timing.refused > 250 && timing.sink_refused == 0, "{timing:?}");
        assert_eq!(run(beats(Angular), &machine(1, 0), &shape).map(|t| t.refused), Ok(0));
    }
}

/// With probability p of refusal an answer takes 1 / (1 - p) cycles on average, and the source feels it.
#[test]
fn a_sink_that_stalls_slows_everything_down() {
    let agents = vec![(0..5000).map(|n| issue(Quadbox, n)).collect::<Vec<_>>(); 4];
    for control in [Control::Skid, Control::Credit] {
        let shape = Shape { control, ..Shape::default() };
        let with = |probability, seed| {
            let sink = Sink::Stalls { probability, seed };
            run(agents.clone(), &Machine { sink, ..machine(4, 0) }, &shape).expect("runs")
        };
        assert_eq!(with(0.0, 1), run(agents.clone(), &machine(4, 0), &shape).expect("runs"));
        let stalled = with(0.75, 1);
        assert!((stalled.cycles as f64 / 80_000.0 - 1.0).abs() < 0.03, "{stalled:?}");
        assert!((stalled.sink_refused as f64 / 60_000.0 - 1.0).abs() < 0.03, "{stalled:?}");
        assert!(stalled.refused > 55_000, "{stalled:?}");
        assert_eq!(with(0.75, 1), stalled);
        assert_ne!(with(0.75, 2).cycles, stalled.cycles);
    }
}

#[test]
fn rates_follow_from_the_clock() {
    let timing = Timing { cycles: 1000, agents: 10, jobs: [100, 400, 0, 0], fetches: 250, ..Timing::default() };
    let rates = timing.at(500.0);
    let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12;
    assert!(close(rates.seconds, 2e-6) && close(rates.jobs, 250e6) && close(rates.agents, 5e6), "{rates:?}");
    assert!(close(rates.fetches, 125e6));
    assert_eq!(Timing::default().jobs_per_cycle(), 0.0);
    assert_eq!((timing.jobs_of(Quadbox), timing.all_jobs()), (400, 500));
}

#[test]
fn agents_that_wait_for_nothing_are_an_error() {
    let error = |agents, machine: &Machine| run(agents, machine, &Shape::default()).err();
    let waits = vec![vec![issue(Quadbox, 0), Step::Wait], vec![Step::Fetch, Step::Wait]];
    assert_eq!(error(waits, &machine(2, 30)), Some(SimulationError::Stuck { agent: 1, cycle: 30 }));
    let twice = vec![vec![issue(Quadbox, 0), Step::Wait, Step::Wait]];
    assert_eq!(error(twice, &machine(2, 30)), Some(SimulationError::Stuck { agent: 0, cycle: 13 }));
    let holds = vec![vec![Step::Issue { job: common::Tag(Angular, 0), holds: true }]];
    assert_eq!(error(holds, &machine(2, 30)), Some(SimulationError::Abandoned { agent: 0, cycle: 1 }));
    assert_eq!(error(Vec::new(), &machine(0, 30)), Some(SimulationError::NoPlace));
    for probability in [1.0, -0.1, f64::INFINITY] {
        let sink = Sink::Stalls { probability, seed: 0 };
        let refused = error(Vec::new(), &Machine { sink, ..machine(1, 1) });
        assert_eq!(refused, Some(SimulationError::Probability(probability)));
    }
    let none = Sink::Stalls { probability: f64::NAN, seed: 0 };
    assert!(matches!(
        error(Vec::new(), &Machine { sink: none, ..machine(1, 1) }),
        Some(SimulationError::Probability(_))
    ));
}

/// Also agents that fetch for ever from memory that costs nothing.
#[test]
fn the_watch_stops_what_has_no_end() {
    struct Endless;
    impl raypath_timing::Agent<Echo> for Endless {
        fn step(&mut self) -> Step<common::Tag> {
            Step::Fetch
        }
        fn answer(&mut self, _: &common::Tag) {}
    }
    for memory_latency in [0, 1, 100] {
        let calls = Cell::new(0);
        let watch = std::sync::atomic::AtomicU64::new(0);
        let stop = |agents| {
            assert_eq!(agents, 0);
            watch.fetch_add(1, std::sync::atomic::Ordering::Relaxed) < 3
        };
        let agents = (0..3).inspect(|_| calls.set(calls.get() + 1)).map(|_| Endless);
        let result = simulate(agents, &machine(2, memory_latency), echo(&Shape::default()), &mut (), &stop);
        assert_eq!(result, Err(SimulationError::Stopped { agents: 0 }));
        assert!(calls.get() <= 2);
    }
    let endless = std::iter::repeat_with(|| Script::<Echo>::new([issue(Quadbox, 0), Step::Wait]));
    let result = simulate(endless, &machine(8, 3), echo(&Shape::default()), &mut (), &|agents| agents < 100_000);
    assert!(matches!(result, Err(SimulationError::Stopped { agents: 100_000.. })));
}

/// What an observer sees does not depend on when it begins to look, and looking changes nothing.
#[test]
fn an_observer_sees_the_cycles_that_it_wants() {
    #[derive(Default)]
    struct Looks {
        from: u64,
        until: u64,
        seen: Vec<(raypath_timing::Cycle, Vec<raypath_model::PipelinePosition>)>,
    }
    impl Observer for Looks {
        fn wants(&self, cycle: u64) -> Option<u64> {
            Some(cycle.max(self.from)).filter(|cycle| *cycle < self.until)
        }
        fn cycle(
            &mut self,
            cycle: &raypath_timing::Cycle,
            places: impl Iterator<Item = raypath_model::PipelinePosition>,
        ) {
            self.seen.push((*cycle, places.collect()));
        }
    }
    let look = |from, until| {
        let mut looks = Looks { from, until, seen: Vec::new() };
        let visit: Vec<_> =
            (0..20).flat_map(|n| [Step::Fetch, issue(Quadbox, n), issue(Angular, n), Step::Wait]).collect();
        let agents = vec![visit; 6].into_iter().map(Script::<Echo>::new);
        let machine = Machine { sink: Sink::Stalls { probability: 0.4, seed: 9 }, ..machine(3, 40) };
        let timing = simulate(agents, &machine, echo(&Shape::default()), &mut looks, &|_| true).expect("runs");
        (timing, looks.seen)
    };
    let (timing, all) = look(0, u64::MAX);
    assert_eq!(all.len() as u64, timing.cycles);
    assert!(all.iter().enumerate().all(|(number, (cycle, _))| cycle.number == number as u64));
    let count = |what: fn(&raypath_timing::Cycle) -> bool| all.iter().filter(|(cycle, _)| what(cycle)).count() as u64;
    assert_eq!(count(|cycle| cycle.accepted), timing.accepted);
    assert_eq!(count(|cycle| cycle.offered.is_some() && !cycle.accepted), timing.refused);
    assert_eq!(count(|cycle| cycle.offered.is_none()), timing.starved.total());
    assert_eq!(count(|cycle| cycle.shown && !cycle.taken), timing.sink_refused);
    assert_eq!(all.iter().map(|(_, places)| places.len() as u64).sum::<u64>(), timing.inside);
    let (same, some) = look(123, 456);
    assert_eq!(same, timing);
    assert_eq!(some, all[123..456]);
    assert_eq!(look(0, 0), (timing, Vec::new()));
}
