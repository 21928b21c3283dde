//! All integration tests of the crate, in one program: it is linked once, and its tests share the cores.

#[macro_use]
mod common;
mod features;
mod operations;
mod package;
mod parameters;
mod staging;
mod tables;
mod text;
