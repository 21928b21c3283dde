//! What is printed, held against independent tools: Verilator simulates it, and three front ends read it.

mod lint;
mod properties;
#[path = "../recorded/mod.rs"]
mod recorded;
mod replay;
mod representatives;
