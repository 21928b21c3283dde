//! What is written for those who integrate the datapath, before the programs that read it.

mod folder;
mod manifests;
mod wrapper;
