//! How many cycles a second are simulated: agents that fetch a node and test its boxes, over and over.
//!
//! `cargo run --release -p raypath-timing --example speed`

#[allow(dead_code)] // of the tests' helpers only the model is used
#[path = "../tests/common/mod.rs"]
mod common;

use raypath_model::{CycleModel, Functional, Model, Shape};
use raypath_ops::{Aabb, Job, JobKind, Ray, RayBoxInput, Rules};
use raypath_timing::{Agent, Machine, SimulationError, Sink, Step, simulate};
use std::hint::black_box;
use std::time::Instant;

/// Visits so many nodes.
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
    fn step(&mut self) -> Step<M::Job> {
        match self.next {
            Next::Fetch if self.visits == 0 => Step::Done,
            Next::Fetch => {
                self.next = Next::Test;
                Step::Fetch
            }
            Next::Test => {
                self.next = Next::Wait;
                Step::Issue { job: self.job.clone(), holds: false }
            }
            Next::Wait => Step::Wait,
        }
    }
    fn answer(&mut self, _: &M::Outcome) {
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
    println!("The model's arithmetic alone: {:.1} M jobs/s", 3.0 / start.elapsed().as_secs_f64());
    println!("Four boxes:");
    measure(Functional::<16, 8>::new(Rules::Paper), job)?;
    println!("Jobs that come out as they went in, which leaves the harness alone:");
    measure(common::Echo, common::Tag(JobKind::Quadbox, 0))?;
    Ok(())
}

fn measure<M: Model<Kind = JobKind>>(model: M, job: M::Job) -> Result<(), SimulationError> {
    for (in_flight, probability) in [(1, 0.0), (8, 0.0), (32, 0.0), (128, 0.0), (1024, 0.0), (128, 0.3)] {
        let agents = (0..100_000).map(|_| Walk { job: job.clone(), visits: 30, next: Next::Fetch });
        let sink = if probability > 0.0 { Sink::Stalls { probability, seed: 1 } } else { Sink::Always };
        let machine = Machine { in_flight, memory_latency: 100, sink };
        let model = CycleModel::new(model.clone(), &Shape::default());
        let start = Instant::now();
        let timing = simulate(agents, &machine, model, &mut (), &|_| true)?;
        let seconds = start.elapsed().as_secs_f64();
        println!(
            "{in_flight:5} in flight, {probability} refused: {:.3} jobs a cycle, {:.1} M cycles/s, {:.1} M jobs/s",
            timing.jobs_per_cycle(),
            timing.cycles as f64 / seconds / 1e6,
            timing.all_jobs() as f64 / seconds / 1e6,
        );
    }
    Ok(())
}
