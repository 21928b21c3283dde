//! All integration tests of the crate, in one program: it is linked once, and its tests share the cores.

mod check;
mod command_line;
mod configuration_files;
mod configurations;
mod golden;
mod isolation;
mod layout;
mod peers;
mod recorded;
mod semantics;
mod tables;
mod verilator;
