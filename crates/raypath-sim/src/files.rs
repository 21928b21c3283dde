//! Writing of files, all or none.

use std::fs;
use std::io::{Error, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;
use thiserror::Error as ThisError;

/// A file or folder that cannot be written.
#[derive(Debug, ThisError)]
#[error("{}: cannot {doing}: {problem}", path.display())]
pub struct FileError {
    /// The file or folder.
    pub path: PathBuf,
    /// The action that failed.
    pub doing: &'static str,
    /// The error of the operating system.
    pub problem: Error,
}

/// Writes all of these files, or none. Writes temporary files beside the targets first and then renames them. Creates
/// missing folders, and removes them if a file cannot be written.
///
/// # Errors
/// A folder or a file that cannot be written.
pub fn write_all<T: AsRef<[u8]>>(files: &[(PathBuf, T)]) -> Result<(), FileError> {
    let mut targets = Vec::new();
    for (path, bytes) in files {
        targets.push((target(path)?, bytes));
    }
    let mut folders = NewFolders(Vec::new());
    let mut written = Vec::new();
    for (path, bytes) in &targets {
        let folder = path.parent().unwrap_or(Path::new("."));
        folders.create(folder)?;
        let mut file =
            NamedTempFile::new_in(folder).map_err(|problem| failed(folder, "write in the folder", problem))?;
        file.write_all(bytes.as_ref()).map_err(|problem| failed(path, "write", problem))?;
        make_readable(&file).map_err(|problem| failed(path, "set its permissions", problem))?;
        written.push((path, file));
    }
    for (path, file) in written {
        file.persist(path).map_err(|problem| failed(path, "write", problem.error))?;
    }
    folders.0.clear();
    Ok(())
}

/// The files with `folder` in front of their paths.
pub fn in_folder(folder: &Path, files: Vec<(PathBuf, String)>) -> Vec<(PathBuf, String)> {
    files.into_iter().map(|(path, text)| (folder.join(path), text)).collect()
}

/// The target of a symbolic link, or the path itself. Only a regular file may be replaced.
fn target(path: &Path) -> Result<PathBuf, FileError> {
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    match fs::metadata(&target) {
        Ok(found) if !found.is_file() => {
            Err(failed(path, "write", Error::other("something else is there, expected a file or nothing")))
        }
        _ => Ok(target),
    }
}

/// The created folders, which are removed on drop if they are empty.
struct NewFolders(Vec<PathBuf>);

impl NewFolders {
    fn create(&mut self, folder: &Path) -> Result<(), FileError> {
        let missing: Vec<&Path> = folder.ancestors().take_while(|above| !above.exists()).collect();
        for above in missing.into_iter().rev().filter(|above| !above.as_os_str().is_empty()) {
            fs::create_dir(above).map_err(|problem| failed(above, "create the folder", problem))?;
            self.0.push(above.to_path_buf());
        }
        Ok(())
    }
}

impl Drop for NewFolders {
    fn drop(&mut self) {
        for folder in self.0.iter().rev() {
            // A folder that has other files by now stays.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// Makes a temporary file, which is private at first, readable for all users.
#[cfg(unix)]
fn make_readable(file: &NamedTempFile) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.as_file().set_permissions(fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn make_readable(_: &NamedTempFile) -> std::io::Result<()> {
    Ok(())
}

fn failed(path: &Path, doing: &'static str, problem: Error) -> FileError {
    FileError { path: path.to_path_buf(), doing, problem }
}
