//! Writing result files.

use crate::error::Error;
use raypath_sim::files::{FileError, write_all};
use std::path::Path;

/// Writes a file atomically, and creates its folder if needed.
pub fn write(path: &Path, text: &str) -> Result<(), Error> {
    write_all(&[(path.to_path_buf(), text)]).map_err(|FileError { path, problem, .. }| Error::File { path, problem })
}
