//! Simulations whose cycle counts follow from formulas, and the errors of invalid agents.

use crate::simulation::common::{Cycles, Echo, Script, Tag, echo, issue};
use raypath_model::{Control, Loop, Shape};
use raypath_ops::JobKind::{Angular, Euclidean, Quadbox};
use raypath_timing::{Action, Environment, SimulationError, Sink, Timing, simulate};
use std::cell::Cell;

fn run(agents: Vec<Vec<Action<Tag>>>, environment: &Environment, shape: &Shape) -> Result<Timing, SimulationError> {
    simulate(agents.into_iter().map(Script::<Echo>::new), environment, echo(shape), &mut (), &|_| true)
}

fn environment(in_flight: usize, memory_latency: u64) -> Environment {
    Environment { in_flight, memory_latency, sink: Sink::Always }
}

/// An accumulator loop of four stages accepts a beat of its operation every four cycles.
#[test]
fn a_loop_in_the_pipeline_refuses_beats() {
    for control in [Control::Skid, Control::Credit] {
        let loops = vec![Loop { opcode: Euclidean.opcode(), first: 6, last: 9 }];
        let shape = Shape { latency: 12, control, interval: 1, loops };
        let beats = |kind| vec![(0..100).map(|n| issue(kind, n)).collect::<Vec<_>>()];
        let timing = run(beats(Euclidean), &environment(1, 0), &shape).expect("runs");
        assert_eq!(timing.cycles, 99 * 4 + 13, "{control:?}");
        assert_eq!(timing.accepted + timing.refused + timing.starved.total(), timing.cycles);
        assert!(timing.refused > 250 && timing.sink_refused == 0, "{timing:?}");
        assert_eq!(run(beats(Angular), &environment(1, 0), &shape).map(|t| t.refused), Ok(0));
    }
}

/// With stall probability p an outcome takes 1 / (1 - p) cycles on average, and back pressure reaches the source.
#[test]
fn sink_stalls_reduce_throughput() {
    let agents = vec![(0..5000).map(|n| issue(Quadbox, n)).collect::<Vec<_>>(); 4];
    for control in [Control::Skid, Control::Credit] {
        let shape = Shape { control, ..Shape::default() };
        let with = |probability, seed| {
            let sink = Sink::Stalls { probability, seed };
            run(agents.clone(), &Environment { sink, ..environment(4, 0) }, &shape).expect("runs")
        };
        assert_eq!(with(0.0, 1), run(agents.clone(), &environment(4, 0), &shape).expect("runs"));
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
    let rates = timing.rates(500.0);
    let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12;
    assert!(close(rates.seconds, 2e-6) && close(rates.jobs, 250e6) && close(rates.agents, 5e6), "{rates:?}");
    assert!(close(rates.fetches, 125e6));
    assert_eq!(Timing::default().jobs_per_cycle(), 0.0);
    assert_eq!((timing.jobs_of(Quadbox), timing.total_jobs()), (400, 500));
}

#[test]
fn invalid_agents_and_environments_are_errors() {
    let error = |agents, environment: &Environment| run(agents, environment, &Shape::default()).err();
    let waits = vec![vec![issue(Quadbox, 0), Action::Wait], vec![Action::Fetch, Action::Wait]];
    assert_eq!(error(waits, &environment(2, 30)), Some(SimulationError::Deadlock { agent: 1, cycle: 30 }));
    let twice = vec![vec![issue(Quadbox, 0), Action::Wait, Action::Wait]];
    assert_eq!(error(twice, &environment(2, 30)), Some(SimulationError::Deadlock { agent: 0, cycle: 13 }));
    assert_eq!(error(Vec::new(), &environment(0, 30)), Some(SimulationError::NoSlots));
    for probability in [1.0, -0.1, f64::INFINITY, f64::NAN] {
        let sink = Sink::Stalls { probability, seed: 0 };
        let refused = error(Vec::new(), &Environment { sink, ..environment(1, 1) });
        let Some(SimulationError::Probability(found)) = refused else { panic!("{refused:?}") };
        assert_eq!(found.to_bits(), probability.to_bits());
    }
}

/// Agents without end are stopped, even those that only fetch from ideal memory.
#[test]
fn the_progress_callback_stops_endless_agents() {
    struct Endless;
    impl raypath_timing::Agent<Echo> for Endless {
        fn next_action(&mut self) -> Action<Tag> {
            Action::Fetch
        }
        fn receive(&mut self, _: &crate::simulation::common::Tag) {}
    }
    for memory_latency in [0, 1, 100] {
        let calls = Cell::new(0);
        let polls = std::sync::atomic::AtomicU64::new(0);
        let stop = |agents| {
            assert_eq!(agents, 0);
            polls.fetch_add(1, std::sync::atomic::Ordering::Relaxed) < 3
        };
        let agents = (0..3).inspect(|_| calls.set(calls.get() + 1)).map(|_| Endless);
        let result = simulate(agents, &environment(2, memory_latency), echo(&Shape::default()), &mut (), &stop);
        assert_eq!(result, Err(SimulationError::Stopped { agents: 0 }));
        assert!(calls.get() <= 2);
    }
    let endless = std::iter::repeat_with(|| Script::<Echo>::new([issue(Quadbox, 0), Action::Wait]));
    let result = simulate(endless, &environment(8, 3), echo(&Shape::default()), &mut (), &|agents| agents < 100_000);
    assert!(matches!(result, Err(SimulationError::Stopped { agents: 100_000.. })));
}

/// The observed activity does not depend on the first observed cycle, and observation does not change the timing.
#[test]
fn an_observer_gets_the_cycles_that_it_selects() {
    let observe = |from, until| {
        let mut recorder = Cycles::between(from, until);
        let visit: Vec<_> =
            (0..20).flat_map(|n| [Action::Fetch, issue(Quadbox, n), issue(Angular, n), Action::Wait]).collect();
        let agents = vec![visit; 6].into_iter().map(Script::<Echo>::new);
        let environment = Environment { sink: Sink::Stalls { probability: 0.4, seed: 9 }, ..environment(3, 40) };
        let timing = simulate(agents, &environment, echo(&Shape::default()), &mut recorder, &|_| true).expect("runs");
        (timing, recorder.seen)
    };
    let (timing, all) = observe(0, u64::MAX);
    assert_eq!(all.len() as u64, timing.cycles);
    assert!(all.iter().enumerate().all(|(number, (cycle, _))| cycle.cycle == number as u64));
    let count =
        |what: fn(&raypath_timing::PortActivity) -> bool| all.iter().filter(|(cycle, _)| what(cycle)).count() as u64;
    assert_eq!(count(|cycle| cycle.accepted), timing.accepted);
    assert_eq!(count(|cycle| cycle.offered.is_some() && !cycle.accepted), timing.refused);
    assert_eq!(count(|cycle| cycle.offered.is_none()), timing.starved.total());
    assert_eq!(count(|cycle| cycle.output_valid && !cycle.output_taken), timing.sink_refused);
    assert_eq!(all.iter().map(|(_, places)| places.len() as u64).sum::<u64>(), timing.latency_sum);
    let (same, some) = observe(123, 456);
    assert_eq!(same, timing);
    assert_eq!(some, all[123..456]);
    assert_eq!(observe(0, 0), (timing, Vec::new()));
}
