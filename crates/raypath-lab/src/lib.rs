//! Operations of one's own.

pub mod check;
mod datapath;
#[doc(hidden)]
pub mod drawing;
pub mod emit;
pub mod engine;
pub mod files;
mod model;
pub mod numbers;
mod operation;
pub mod picture;
#[doc(hidden)]
pub mod progress;
pub mod tables;
pub mod traffic;

pub use datapath::Datapath;
pub use model::{AnyKind, AnyModel, Words};
pub use operation::AnyOperation;
