//! All integration tests of the crate, in one program: it is linked once, and its tests share the cores.

mod builder_errors;
mod clock_gates;
mod hierarchy;
mod memories;
mod mutate;
mod operators;
mod random_netlists;
mod registers;
mod verilog;
mod waves;
