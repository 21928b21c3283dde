//! Result files, and the files of a folder.

use crate::error::Error;
use raypath_sim::files::{FileError, write_all};
use raypath_tools::ToolError;
use std::path::{Path, PathBuf};

/// Writes a file atomically, and creates its folder if needed.
pub fn write(path: &Path, text: &str) -> Result<(), Error> {
    let refused = |FileError { path, doing, problem }| ToolError::File { path, doing, problem };
    Ok(write_all(&[(path.to_path_buf(), text)]).map_err(refused)?)
}

/// What a folder contains, in the order of names.
pub fn in_folder(folder: &Path) -> Result<Vec<PathBuf>, ToolError> {
    let refused = |problem| ToolError::file(folder, "read", problem);
    let entries = std::fs::read_dir(folder).map_err(refused)?;
    let paths: Result<Vec<PathBuf>, _> = entries.map(|entry| entry.map(|entry| entry.path())).collect();
    let mut paths = paths.map_err(refused)?;
    paths.sort();
    Ok(paths)
}
