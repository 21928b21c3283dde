//! The files for integration, read by the programs that use them.

mod cocotb;
mod folder;
#[path = "../../raypath-tools/tests/verilator/frames.rs"]
mod frames;
mod manifests;
mod wrapper;
