//! Sweeps: each point equals a simulation of its own, and the plot shows every point.

use crate::simulation::common::{Echo, Script, echo, issue};
use raypath_model::Shape;
use raypath_ops::JobKind::Quadbox;
use raypath_timing::{Action, Environment, SimulationError, Sweep, plot, simulate, sweep};
use std::sync::atomic::{AtomicU64, Ordering};

const IN_FLIGHT: [usize; 6] = [1, 2, 8, 40, 113, 400];
const LATENCIES: [u64; 3] = [100, 0, 20];

fn agents() -> impl Iterator<Item = Script<Echo>> {
    (0..2000).map(|n| {
        Script::new([Action::Fetch, issue(Quadbox, n), Action::Wait, Action::Fetch, issue(Quadbox, n), Action::Wait])
    })
}

fn run() -> Sweep {
    let model = echo(&Shape::default());
    sweep(&IN_FLIGHT, &LATENCIES, &Environment::default(), &model, agents, &|_| true).expect("runs")
}

#[test]
fn each_point_equals_a_simulation_of_its_own() {
    let sweep = run();
    assert_eq!(sweep.points.len(), IN_FLIGHT.len() * LATENCIES.len());
    for (index, point) in sweep.points.iter().enumerate() {
        let (latency, in_flight) = (LATENCIES[index / IN_FLIGHT.len()], IN_FLIGHT[index % IN_FLIGHT.len()]);
        assert_eq!((point.environment.memory_latency, point.environment.in_flight), (latency, in_flight));
        let (jobs, agents) = (point.timing.jobs_per_cycle(), point.timing.agents_per_cycle());
        assert!((agents * 2.0 - jobs).abs() < 1e-12, "{point:?}");
        let alone = simulate(self::agents(), &point.environment, echo(&Shape::default()), &mut (), &|_| true);
        assert_eq!(alone, Ok(point.timing));
    }
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    assert_eq!(pool.install(run), run());
}

#[test]
fn a_sweep_can_be_stopped_and_can_fail() {
    let model = echo(&Shape::default());
    let most = AtomicU64::new(0);
    let stop = |agents| {
        most.fetch_max(agents, Ordering::Relaxed);
        agents < 30_000
    };
    let endless = || std::iter::repeat_with(|| Script::<Echo>::new([issue(Quadbox, 0), Action::Wait]));
    let result = sweep(&[1, 2, 3], &[5], &Environment::default(), &model, endless, &stop);
    assert!(matches!(result, Err(SimulationError::Stopped { .. })), "{result:?}");
    // A point completes some ten thousand agents between two calls.
    assert!((30_000..200_000).contains(&most.load(Ordering::Relaxed)), "{most:?}");
    let result = sweep(&[1, 0], &[5], &Environment::default(), &model, agents, &|_| true);
    assert_eq!(result, Err(SimulationError::NoSlots));
}

#[test]
fn the_plot_shows_every_point_and_escapes_its_title() {
    let picture = plot(&run(), "Rays <& queries>", "rays");
    assert_eq!(picture.matches("<circle").count(), 2 * IN_FLIGHT.len() * LATENCIES.len());
    assert_eq!(picture.matches("<polyline").count(), 2 * LATENCIES.len());
    for words in
        ["jobs per cycle", "rays per cycle", "rays in flight", "memory latency", "100 cycles", "&lt;&amp; queries&gt;"]
    {
        assert!(picture.contains(words), "{words}");
    }
    assert!(!picture.contains("NaN") && !picture.contains("inf"));
    // On a logarithmic axis the distance from one to eight is three times that from one to two.
    let x = |in_flight: usize| {
        let title = format!("{in_flight} rays in flight, memory latency 20 cycles");
        let circle = picture.split("<circle").find(|circle| circle.contains(&title)).expect("a point");
        let x = circle.split("cx=\"").nth(1).and_then(|rest| rest.split('"').next()).expect("cx");
        x.parse::<f64>().expect("a number")
    };
    assert!(((x(8) - x(1)) / (x(2) - x(1)) - 3.0).abs() < 0.02);
    let empty = plot(&Sweep::default(), "Nothing", "rays");
    assert!(!empty.contains("NaN") && !empty.contains("inf"));
}
