//! All integration tests of the crate, in one program: it is linked once, and its tests share the cores.

mod common;
mod measure;
mod page;
mod power;
mod refused;
mod search;
mod shown;
