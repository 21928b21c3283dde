//! Files that appear whole or not at all.

use crate::commands::Failure;
use raypath::sim::files::{self, FileError};
use std::io::Write;
use std::path::PathBuf;

/// Writes all of these files, or none.
pub fn write_all<T: AsRef<[u8]>>(files: &[(PathBuf, T)]) -> Result<(), Failure> {
    Ok(files::write_all(files)?)
}

/// Writes all of these files, or none, and says where they are.
pub fn write_and_name<T: AsRef<[u8]>>(files: &[(PathBuf, T)], out: &mut dyn Write) -> Result<(), Failure> {
    write_all(files)?;
    files.iter().try_for_each(|(path, _)| writeln!(out, "wrote {}", path.display()))?;
    Ok(())
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        Self::unusable(error)
    }
}
