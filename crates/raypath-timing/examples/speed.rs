//! Measures the speed of the simulation in cycles per second, with agents that repeatedly fetch a node and test its
//! boxes.
//!
//! `cargo run --release -p raypath-timing --example speed`

#[allow(dead_code)] // only the model of the tests' helpers is used
#[path = "../tests/simulation/common.rs"]
mod common;

use raypath_model::{CycleModel, Functional, Model, Shape};
use raypath_ops::{Aabb, Job, JobKind, Ray, RayBoxInput, Rules};
use raypath_timing::{Action, Agent, Environment, SimulationError, Sink, simulate};
use std::hint::black_box;
use std::time::Instant;

/// An agent that visits `visits` nodes.
struct Walk<J> {
    job: J,
    visits: u32,
    next: Next,
}

enum Next {
    Fetch,
    Test,
    Wait,
}

impl<M: Model> Agent<M> for Walk<M::Job> {
    fn next_action(&mut self) -> Action<M::Job> {
        match self.next {
            Next::Fetch if self.visits == 0 => Action::Done,
            Next::Fetch => {
                self.next = Next::Test;
                Action::Fetch
            }
            Next::Test => {
                self.next = Next::Wait;
                Action::Issue { job: self.job.clone(), lock: false }
            }
            Next::Wait => Action::Wait,
        }
    }
    fn receive(&mut self, _: &M::Outcome) {
        self.visits -= 1;
        self.next = Next::Fetch;
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let ray = Ray::new([0.0, 0.0, -5.0], [0.0, 0.0, 1.0], f32::INFINITY)?;
    let job = Job::Quadbox(RayBoxInput { ray, aabb: [Aabb::new([-1.0; 3], [1.0; 3]); 4] });
    let mut alone = Functional::<16, 8>::new(Rules::Paper);
    let start = Instant::now();
    (0..3_000_000).for_each(|_| _ = black_box(alone.run(black_box(&job))));
    println!("Arithmetic of the functional model: {:.1} M jobs/s", 3.0 / start.elapsed().as_secs_f64());
    println!("Simulation of box tests:");
    measure(Functional::<16, 8>::new(Rules::Paper), job)?;
    println!("Simulation without arithmetic:");
    measure(common::Echo, common::Tag(JobKind::Quadbox, 0))?;
    Ok(())
}

fn measure<M: Model<Kind = JobKind>>(model: M, job: M::Job) -> Result<(), SimulationError> {
    for (in_flight, probability) in [(1, 0.0), (8, 0.0), (32, 0.0), (128, 0.0), (1024, 0.0), (128, 0.3)] {
        let agents = (0..100_000).map(|_| Walk { job: job.clone(), visits: 30, next: Next::Fetch });
        let sink = if probability > 0.0 { Sink::Stalls { probability, seed: 1 } } else { Sink::Always };
        let environment = Environment { in_flight, memory_latency: 100, sink };
        let pipeline = CycleModel::new(model.clone(), &Shape::default());
        let start = Instant::now();
        let timing = simulate(agents, &environment, pipeline, &mut (), &|_| true)?;
        let seconds = start.elapsed().as_secs_f64();
        println!(
            "{in_flight:5} in flight, {probability} stalled: {:.3} jobs per cycle, {:.1} M cycles/s, {:.1} M jobs/s",
            timing.jobs_per_cycle(),
            timing.cycles as f64 / seconds / 1e6,
            timing.total_jobs() as f64 / seconds / 1e6,
        );
    }
    Ok(())
}
