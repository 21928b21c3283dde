//! The Python module `raypath._raypath`, which the package `crates/raypath-python/python/raypath` exports.
//!
//! Documentation comments of classes and functions are their docstrings in Python.

mod array;
mod bench;
mod config;
mod datapath;
mod error;
mod hits;
mod job;
mod pipeline;
mod query;
mod render;
mod tables;
mod timing;
mod unit;
mod unit_model;
mod unit_search;
mod watch;
mod words;

use pyo3::prelude::*;
use raypath_oracle::AnyOperationSpec;

/// Adds an operation of one's own, in the initialisation of a module that is built with this crate. The package
/// `raypath`, imported after that module, then has this library for its own.
///
/// # Errors
/// A name that an operation has; the package, or another module with an operation, was imported before.
pub fn add_operation(py: Python<'_>, spec: impl Into<AnyOperationSpec>) -> PyResult<()> {
    let modules = py.import("sys")?.getattr("modules")?;
    if modules.contains("raypath")? || modules.contains("raypath._raypath")? {
        return Err(error::value_error(
            "raypath or a module like this is imported already, expected this one before it",
        ));
    }
    raypath_oracle::add_operation(spec).map_err(error::value_error)?;
    modules.set_item("raypath._raypath", pyo3::wrap_pymodule!(_raypath)(py))
}

/// The parts of raypath that are written in Rust.
#[pymodule]
mod _raypath {
    use super::*;
    use std::ffi::OsString;

    #[pymodule_export]
    use crate::array::rays;
    #[pymodule_export]
    use crate::bench::rust_seconds;
    #[pymodule_export]
    use crate::datapath::Datapath;
    #[pymodule_export]
    use crate::hits::{QuadboxHits, Trace, TriangleHits, UnitHits};
    #[pymodule_export]
    use crate::job::{Job, Outcome};
    #[pymodule_export]
    use crate::pipeline::Pipeline;
    #[pymodule_export]
    use crate::query::RayQuery;
    #[pymodule_export]
    use crate::render::{PyScene, Rendering, render, trace};
    #[pymodule_export]
    use crate::tables::{operations, parameters, presets, read_card};
    #[pymodule_export]
    use crate::unit::{Unit, UnitScene};
    #[pymodule_export]
    use crate::unit_model::{UnitModel, UnitOutputs};
    #[pymodule_export]
    use crate::unit_search::{SavedGraph, UnitSearch, read_graph};

    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("RAY", crate::array::dtype::<raypath_embed::Ray>(module.py())?)?;
        module.add("UNIT_RAY", crate::array::dtype::<raypath_embed::UnitRay>(module.py())?)
    }

    /// Runs the command line `arguments`, the first of which is the name of the program, and returns the exit code.
    #[pyfunction]
    fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
        py.detach(|| raypath_cli::run(arguments))
    }
}
