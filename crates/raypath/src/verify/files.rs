//! Files that verification leaves behind.

use raypath_verify::Error;
use std::fs;
use std::io::{self, Write};
use std::path::Path;
use tempfile::Builder;

/// Writes a file beside its place first, and moves it when it is whole. Makes the folder where it is missing.
pub fn write(path: &Path, text: &str) -> Result<(), Error> {
    written(path, text).map_err(|problem| Error::File { path: path.to_path_buf(), problem })
}

fn written(path: &Path, text: &str) -> io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::create_dir_all(folder)?;
    let mut builder = Builder::new();
    // Temporary files are private; this one is for everybody, as far as the folder is.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644));
    let mut file = builder.tempfile_in(folder)?;
    file.write_all(text.as_bytes())?;
    file.persist(path).map_err(|problem| problem.error)?;
    Ok(())
}
