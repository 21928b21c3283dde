//! The printed text in independent tools: Verilator simulates it, and three linters read it.

mod lint;
mod properties;
mod replay;
mod representatives;
