//! Compares the netlist simulator with Verilator, and runs the linters on emitted SystemVerilog.

mod clock_gates;
mod compare;
mod coverage;
#[path = "../../raypath-hdl/tests/common/operators.rs"]
mod every;
mod frames;
mod memories;
#[path = "../../raypath-hdl/tests/common/netlists.rs"]
mod netlists;
mod operators;
mod process;
mod random;
mod registers;
