//! What is written for those who integrate the datapath, before the programs that read it.

mod cocotb;
mod folder;
mod manifests;
mod wrapper;
