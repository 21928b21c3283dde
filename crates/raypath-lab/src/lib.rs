//! Operations of one's own.

pub mod check;
mod checks;
mod command;
mod cost;
mod datapath;
#[doc(hidden)]
pub mod drawing;
pub mod emit;
pub mod engine;
mod error;
pub mod files;
pub mod frames;
mod model;
pub mod numbers;
mod operation;
pub mod picture;
pub mod prelude;
#[doc(hidden)]
pub mod progress;
mod stimuli;
mod study;
pub mod tables;
pub mod traffic;

pub use raypath_ops as ops;
pub use raypath_rtl as rtl;

pub use checks::{Checks, Judged, Simulated};
pub use command::{Arguments, main, run};
pub use cost::{Cost, Figures};
pub use datapath::Datapath;
pub use error::LabError;
pub use model::{AnyKind, AnyModel, Words};
pub use operation::AnyOperation;
pub use stimuli::any_job;
pub use study::{AnyStudy, Registered, Study, registered};
