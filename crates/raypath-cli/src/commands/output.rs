//! Files that appear whole or not at all.

use crate::error::CliError;
use raypath_sim::files;
use std::path::PathBuf;

/// Writes all of these files, or none.
pub fn write_all<T: AsRef<[u8]>>(files: &[(PathBuf, T)]) -> Result<(), CliError> {
    Ok(files::write_all(files)?)
}
