//! The operation for C, as a library with the functions of libraypath (feature `c`), and for Python, as a module after
//! which `import raypath` has the operation (feature `python`).

#[cfg(feature = "c")]
pub use raypath_capi::*;

/// Adds the operation to those that `raypath_open_with` finds by name. Returns false if there is one of its name.
#[cfg(feature = "c")]
#[unsafe(no_mangle)]
pub extern "C" fn within_radius_add() -> bool {
    raypath_oracle::add_operation(operation::spec()).is_ok()
}

/// The module.
#[cfg(feature = "python")]
#[pyo3::pymodule]
mod within_radius {
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        _raypath::add_operation(module.py(), operation::spec())
    }
}
