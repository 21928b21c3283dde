//! All integration tests of the crate, in one program: it is linked once, and its tests share the cores.

mod axi;
mod bound;
mod cache;
mod common;
mod descent;
mod instances;
mod quantised;
mod queries;
mod scenes;
mod search;
mod search_hardware;
mod state;
mod system;
mod unit;
