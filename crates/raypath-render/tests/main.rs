//! All integration tests of the crate, in one program: it is linked once, and its tests share the cores.

mod common;
mod hits;
mod instances;
mod peer;
mod pictures;
mod quantised;
mod ray_files;
mod readers;
mod refit;
mod timing;
mod tree;
mod unit;
mod unit_netlist;
mod watertight;
