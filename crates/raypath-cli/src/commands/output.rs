//! Files that appear whole or not at all.

use crate::error::CliError;
use raypath_sim::files;
use std::io::Write;
use std::path::PathBuf;

/// Writes all of these files, or none.
pub fn write_all<T: AsRef<[u8]>>(files: &[(PathBuf, T)]) -> Result<(), CliError> {
    Ok(files::write_all(files)?)
}

/// Writes all of these files, or none, and says where they are.
#[cfg_attr(not(feature = "full"), allow(dead_code))]
pub fn write_and_name<T: AsRef<[u8]>>(files: &[(PathBuf, T)], out: &mut dyn Write) -> Result<(), CliError> {
    write_all(files)?;
    files.iter().try_for_each(|(path, _)| writeln!(out, "wrote {}", path.display()))?;
    Ok(())
}
