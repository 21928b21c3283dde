//! Errors of the Rust libraries as exceptions of Python.

use pyo3::PyErr;
use pyo3::exceptions::{PyOSError, PyValueError};
use raypath_embed::Error;
use std::fmt::Display;

/// A `ValueError` with this message.
pub fn value_error(problem: impl Display) -> PyErr {
    PyValueError::new_err(problem.to_string())
}

/// A file that cannot be written is an `OSError`; everything else is an argument and a `ValueError`.
pub fn exception(error: Error) -> PyErr {
    match error {
        Error::File(error) => PyOSError::new_err(error.to_string()),
        error => value_error(error),
    }
}
