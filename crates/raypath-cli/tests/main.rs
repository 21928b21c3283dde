//! All integration tests of the crate, in one program: it is linked once, and its tests share the cores.

mod any_operations;
mod check;
mod golden;
mod isolation;
#[path = "../../raypath/tests/recorded/mod.rs"]
mod recorded;
mod transactions;
mod verilator;
