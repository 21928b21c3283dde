//! Operations of one's own.

pub mod check;
#[doc(hidden)]
pub mod drawing;
pub mod engine;
pub mod picture;
pub mod tables;
pub mod traffic;
