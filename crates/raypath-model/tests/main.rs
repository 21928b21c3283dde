//! All integration tests of the crate, in one program: it is linked once, and its tests share the cores.

mod common;
mod elastic;
mod folded;
mod formats;
mod lanes;
mod models;
mod vectors;
mod words;
