//! Files that appear whole or not at all.

use crate::commands::Failure;
use std::io::Write;
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Writes all of these files, or none: each is written beside its place first, and moved when every one is there.
pub fn write_all(files: &[(PathBuf, String)]) -> Result<(), Failure> {
    let mut written = Vec::new();
    for (path, text) in files {
        if path.is_dir() {
            return Err(Failure::file(path, "write", "a folder is there, expected a file or nothing"));
        }
        let folder = path.parent().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder).map_err(|problem| Failure::file(folder, "create the folder", problem))?;
        let mut file =
            NamedTempFile::new_in(folder).map_err(|problem| Failure::file(folder, "write in the folder", problem))?;
        file.write_all(text.as_bytes()).map_err(|problem| Failure::file(path, "write", problem))?;
        make_readable(&file).map_err(|problem| Failure::file(path, "set its permissions", problem))?;
        written.push((path, file));
    }
    for (path, file) in written {
        file.persist(path).map_err(|problem| Failure::file(path, "write", problem.error))?;
    }
    Ok(())
}

/// Temporary files are private; these are for everybody, as far as the folder is.
#[cfg(unix)]
fn make_readable(file: &NamedTempFile) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.as_file().set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn make_readable(_: &NamedTempFile) -> std::io::Result<()> {
    Ok(())
}
