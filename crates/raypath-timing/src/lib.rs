//! How long the datapath takes when many agents keep it busy, and why.
//!
//! An [`Agent`] is whatever asks the datapath for answers one after another, a ray on its way through a tree or a query
//! among vectors. [`simulate`] keeps many of them in flight before a cycle-exact model and counts: cycles, jobs, and
//! for each cycle in which no job entered the reason. [`sweep`] does so for many machines, and [`plot`] draws it.
//!
//! ```
//! use raypath_model::{CycleModel, Functional, Shape};
//! use raypath_ops::{Aabb, Job, Outcome, Ray, RayBoxInput, Rules};
//! use raypath_timing::{Agent, Machine, Step, simulate};
//!
//! /// Fetches one node of a tree, and tests its boxes.
//! struct Visit {
//!     steps: std::vec::IntoIter<Step<Job>>,
//! }
//!
//! impl Agent<Functional> for Visit {
//!     fn step(&mut self) -> Step<Job> {
//!         self.steps.next().unwrap_or(Step::Done)
//!     }
//!     fn answer(&mut self, _: &Outcome) {}
//! }
//!
//! let ray = Ray::new([0.0, 0.0, -5.0], [0.0, 0.0, 1.0], f32::INFINITY)?;
//! let job = Job::Quadbox(RayBoxInput { ray, aabb: [Aabb::new([-1.0; 3], [1.0; 3]); 4] });
//! let visit = || Visit { steps: vec![Step::Fetch, Step::Issue { job, holds: false }, Step::Wait].into_iter() };
//!
//! let machine = Machine { in_flight: 1, memory_latency: 100, ..Machine::default() };
//! let model = CycleModel::new(Functional::new(Rules::Paper), &Shape::default());
//! let timing = simulate((0..10).map(|_| visit()), &machine, model, &mut (), &|_| true)?;
//! // Memory, the twelve cycles inside, and the one in which the answer is taken.
//! assert_eq!(timing.cycles, 10 * (100 + 12 + 1));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod agent;
mod hardware;
mod machine;
mod observer;
#[cfg(feature = "sweep")]
mod plot;
#[cfg(feature = "report")]
pub mod report;
mod sample;
mod simulation;
#[cfg(feature = "sweep")]
mod sweep;
mod timing;

pub use agent::{Agent, Step};
pub use hardware::Hardware;
pub use machine::{Machine, Sink};
pub use observer::{Cycle, Observer};
#[cfg(feature = "sweep")]
pub use plot::plot;
pub use sample::Sample;
pub use simulation::{SimulationError, Watch, simulate};
#[cfg(feature = "sweep")]
pub use sweep::{Point, Sweep, sweep};
pub use timing::{Rates, Starved, Timing};
