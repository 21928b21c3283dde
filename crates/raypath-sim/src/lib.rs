//! Simulation of a ray-tracer datapath of any operations.
//!
//! A [`Datapath`] is a set of operations and a configuration. It determines a netlist, a functional model and a
//! cycle-exact model. An [`engine`] runs jobs through any of the three, under [`traffic`] with bubbles and stalls, and
//! [`lockstep`] compares them in every cycle. [`transactions`] are files of jobs with their outcomes.
//!
//! ```
//! use raypath_ops::{RayBox, RayTriangle, Rounding, Rules};
//! use raypath_sim::Datapath;
//! use raypath_sim::lockstep::lockstep;
//! use raypath_sim::{jobs::any_jobs, traffic::Traffic};
//!
//! let rules = Rules::Paper;
//! let datapath = Datapath::new().with(RayBox { rules, is_conservative: false }).with(RayTriangle { rules, rounding: Rounding::Unit });
//! let elaborated = datapath.elaborate()?;
//! let mut netlist = datapath.netlist(&elaborated)?;
//! let jobs = any_jobs(datapath.model(), 1).take(200);
//! let found = lockstep(&mut netlist, datapath.model(), jobs, &mut Traffic::random(1), |_| true);
//! assert_eq!((found.jobs, found.different), (200, 0));
//! # Ok::<(), raypath_rtl::Error>(())
//! ```

pub mod configuration;
mod datapath;
pub mod engine;
pub mod files;
pub mod frames;
mod input;
pub mod jobs;
pub mod lockstep;
pub mod numbers;
pub mod random;
pub mod traffic;
pub mod transactions;

pub use datapath::{AnyOperation, Datapath};
pub use input::InputError;
pub use raypath_model::{OperationId, WordModel, Words};
