//! The printed text in independent tools: Verilator simulates it, and three linters read it.

mod lint;
mod properties;
#[path = "../recorded/mod.rs"]
mod recorded;
mod replay;
mod representatives;
