//! The netlist's simulator against Verilator, and the printed text before the linters.

mod compare;
mod operators;
mod process;
mod random;
mod registers;
