//! Readers of vector files: files of other programs, truncated files, and files with wrong content or headers.

mod common;
mod hdf5;
mod npy;
mod saved_graph;
mod texmex;
