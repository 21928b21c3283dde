//! Output files that are named on standard output.

use crate::commands::output::write_all;
use crate::error::CliError;
use std::io::Write;
use std::path::PathBuf;

/// Writes all of these files, or none, and prints their paths.
pub fn write_and_name<T: AsRef<[u8]>>(files: &[(PathBuf, T)], out: &mut dyn Write) -> Result<(), CliError> {
    write_all(files)?;
    files.iter().try_for_each(|(path, _)| writeln!(out, "wrote {}", path.display()))?;
    Ok(())
}
