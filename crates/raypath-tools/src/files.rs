//! The files that programs read.

use crate::ToolError;
use std::path::Path;
use tempfile::TempDir;

/// Writes text to a file.
///
/// # Errors
/// It cannot be written.
pub fn write(path: &Path, text: &str) -> Result<(), ToolError> {
    std::fs::write(path, text).map_err(|problem| ToolError::file(path, "write", problem))
}

/// Reads a file.
///
/// # Errors
/// It cannot be read.
pub fn read(path: &Path) -> Result<Vec<u8>, ToolError> {
    std::fs::read(path).map_err(|problem| ToolError::file(path, "read", problem))
}

/// A folder that is deleted when it goes out of scope.
///
/// # Errors
/// It cannot be created.
pub fn temporary_folder() -> Result<TempDir, ToolError> {
    tempfile::tempdir().map_err(|problem| ToolError::file(&std::env::temp_dir(), "create a folder in", problem))
}
