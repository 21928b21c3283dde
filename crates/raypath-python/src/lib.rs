//! The Python module `raypath._raypath`, which the package `crates/raypath-python/python/raypath` exports.

use pyo3::prelude::*;

#[pymodule]
mod _raypath {
    use super::*;
    use std::ffi::OsString;

    /// Runs the command line `arguments`, the first of which is the name of the program, and returns the exit code.
    #[pyfunction]
    fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
        py.detach(|| raypath_cli::run(arguments))
    }
}
