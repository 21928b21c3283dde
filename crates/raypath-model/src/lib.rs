//! Models of the datapath over binary32: what it answers ([`Functional`]) and when ([`CycleModel`]); and circuits to run
//! its operations over in other formats: any small one in software ([`Soft`]), and [`Binary64`].
//!
//! Arithmetic depends on the jobs and their order alone, time on handshakes alone. So the cycle-exact model computes a
//! job's outcome once, when it enters, and carries it through twelve skid buffers.
//!
//! ```
//! use raypath_model::{CycleModel, LATENCY};
//! use raypath_ops::{Aabb, Binary32, Job, Ray, RayBoxInput, Rules};
//!
//! let ray = Ray::new([0.0, 0.0, -5.0], [0.0, 0.0, 1.0], f32::INFINITY)?;
//! let job: Job = Job::Quadbox(RayBoxInput { ray, aabb: [Aabb::new([-1.0; 3], [1.0; 3]); 4] });
//!
//! let mut datapath = CycleModel::new(Rules::Paper);
//! assert!(datapath.cycle(Some(&job), true).accepted);
//! let mut cycles = 1;
//! while datapath.output().is_none() {
//!     datapath.cycle(None, true);
//!     cycles += 1;
//! }
//! assert_eq!(cycles, LATENCY);
//! # Ok::<(), raypath_ops::RayError>(())
//! ```

mod binary64;
mod cycle;
mod elastic;
mod functional;
mod logic;
mod soft;

pub use binary64::{Binary64, Double};
pub use cycle::CycleModel;
pub use elastic::{Elastic, Transfer};
pub use functional::Functional;
pub use soft::{Soft, SoftNumber};

/// Cycles from the one in which a job is accepted to the one that shows its outcome, in an empty pipeline.
pub const LATENCY: usize = 12;
