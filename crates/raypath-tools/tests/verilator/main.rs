//! Compares the netlist simulator with Verilator, and runs the linters on emitted SystemVerilog.

mod compare;
mod operators;
mod process;
mod random;
mod registers;
