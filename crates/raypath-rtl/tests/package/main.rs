//! What is written for those who integrate the datapath, before the programs that read it.

mod cocotb;
mod folder;
#[path = "../../../raypath-tools/tests/verilator/frames.rs"]
mod frames;
mod manifests;
mod wrapper;
