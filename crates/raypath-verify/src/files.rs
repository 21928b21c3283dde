//! Result files.

use crate::error::Error;
use raypath_sim::files::{FileError, write_all};
use raypath_tools::ToolError;
use std::path::Path;

/// Writes a file atomically, and creates its folder if needed.
pub fn write(path: &Path, text: &str) -> Result<(), Error> {
    let refused = |FileError { path, doing, problem }| ToolError::File { path, doing, problem };
    Ok(write_all(&[(path.to_path_buf(), text)]).map_err(refused)?)
}
