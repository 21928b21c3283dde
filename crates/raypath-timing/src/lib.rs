//! Simulation of the datapath under load: throughput, latency, and the causes of idle cycles.
//!
//! An [`Agent`] is a client of the datapath that issues jobs and waits for their outcomes, such as a ray that traverses
//! a tree or a query that searches vectors. [`simulate`] keeps many agents in flight before a cycle-exact model and
//! counts cycles and jobs, and for each cycle without a job the cause. [`sweep`] repeats this for several numbers of
//! agents and memory latencies, and [`plot`] draws the result. Module [`report`] shows a run as an HTML page with a
//! timeline.
//!
//! Feature `sweep` enables [`sweep`] and [`plot`], feature `report` the module [`report`]; both are on by default.
//!
//! ```
//! use raypath_model::{CycleModel, Functional, Shape};
//! use raypath_ops::{Aabb, Job, Outcome, Ray, RayBoxInput, Rules};
//! use raypath_timing::{Action, Agent, Environment, simulate};
//!
//! /// Fetches one node of a tree and tests its boxes.
//! struct Visit {
//!     actions: std::vec::IntoIter<Action<Job>>,
//! }
//!
//! impl Agent<Functional> for Visit {
//!     fn next_action(&mut self) -> Action<Job> {
//!         self.actions.next().unwrap_or(Action::Done)
//!     }
//!     fn receive(&mut self, _: &Outcome) {}
//! }
//!
//! let ray = Ray::new([0.0, 0.0, -5.0], [0.0, 0.0, 1.0], f32::INFINITY)?;
//! let job = Job::Quadbox(RayBoxInput { ray, aabb: [Aabb::new([-1.0; 3], [1.0; 3]); 4] });
//! let actions = [Action::Fetch, Action::Issue(job), Action::Wait];
//! let agents = (0..10).map(|_| Visit { actions: actions.to_vec().into_iter() });
//!
//! let environment = Environment { in_flight: 1, memory_latency: 100, ..Environment::default() };
//! let pipeline = CycleModel::new(Functional::new(Rules::Paper), &Shape::default());
//! let timing = simulate(agents, &environment, pipeline, &mut (), &|_| true)?;
//! // The memory latency, twelve cycles in the pipeline, and one cycle at the output.
//! assert_eq!(timing.cycles, 10 * (100 + 12 + 1));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod agent;
mod environment;
#[cfg(feature = "sweep")]
mod plot;
mod progress;
mod record;
#[cfg(feature = "report")]
pub mod report;
mod simulation;
#[cfg(feature = "sweep")]
mod sweep;
mod timing;

pub use agent::{Action, Agent, Observer, PortActivity};
pub use environment::{Environment, Sample, Sink, System};
#[cfg(feature = "sweep")]
pub use plot::{Panel, Plot, Series, plot};
pub use progress::{Progress, ProgressCounter};
pub use record::accepted_jobs;
pub use simulation::{SimulationError, simulate};
#[cfg(feature = "sweep")]
pub use sweep::{Point, Sweep, sweep};
pub use timing::{Rates, Starved, Timing};
