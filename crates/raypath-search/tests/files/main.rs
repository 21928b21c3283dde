//! Readers before files as other programs make them, and before files that are cut, wrong, or lie.

mod common;
mod hdf5;
mod npy;
mod texmex;
