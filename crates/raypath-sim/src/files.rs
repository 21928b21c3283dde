//! Writing of files, each of them whole.

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

/// Writes these files: first all of them as temporary files beside their targets, then renames these in order. Creates
/// missing folders, and removes those that are empty after an error.
///
/// A target is its old file or its new one, never a part of it. If the temporary files cannot be written, because the
/// disk is full for example, every target is as it was. If a rename fails or the program is ended between renames, the
/// targets before it are new and the others as they were.
///
/// # Errors
/// A folder or a file that cannot be written. If some files are new by then, the message says how many.
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
    let total = written.len();
    for (done, (path, file)) in written.into_iter().enumerate() {
        file.persist(path).map_err(|problem| match done {
            0 => failed(path, "write", problem.error),
            _ => failed(path, "write", partly(&problem.error, done, total)),
        })?;
    }
    folders.0.clear();
    Ok(())
}

/// Writes a design into a folder as [`write_all`] does. Then removes the modules of another configuration: the files in
/// `rtl` that a list of sources (`*.f`) named before this call replaced it, and that are not written now.
///
/// # Errors
/// As of [`write_all`]; a file that cannot be removed.
pub fn write_design(folder: &Path, files: &[(PathBuf, String)]) -> Result<(), FileError> {
    let lists = files.iter().map(|(path, _)| path).filter(|path| path.extension().is_some_and(|is| is == "f"));
    let listed: Vec<String> = lists.filter_map(|list| fs::read_to_string(list).ok()).collect();
    write_all(files)?;
    let is_module = |line: &&str| line.strip_prefix("rtl/").is_some_and(|name| !name.contains('/'));
    for path in listed.iter().flat_map(|list| list.lines()).filter(is_module) {
        let path = folder.join(path);
        if path.is_file() && files.iter().all(|(new, _)| *new != path) {
            fs::remove_file(&path).map_err(|problem| failed(&path, "remove the file of another design", problem))?;
        }
    }
    Ok(())
}

fn partly(problem: &Error, done: usize, total: usize) -> Error {
    Error::new(problem.kind(), format!("{problem}; {done} of {total} files are written, expected all"))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_before_the_first_rename_leaves_everything_as_it_was() {
        let folder = tempfile::tempdir().expect("a folder");
        let (old, new) = (folder.path().join("old"), folder.path().join("new/file"));
        fs::write(&old, "old").expect("a file");
        // A file is not a folder.
        let files = [(old.clone(), "new"), (new.clone(), "new"), (old.join("below"), "new")];
        assert_eq!(write_all(&files).expect_err("no folder").path, old);
        assert_eq!(fs::read_to_string(&old).expect("the file"), "old");
        assert_eq!(fs::read_dir(folder.path()).expect("the folder").count(), 1);
    }

    #[test]
    fn another_design_replaces_the_files_of_the_first() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        let write = |module: &str| {
            let files = [("a.f", format!("rtl/{module}.sv\n")), (&format!("rtl/{module}.sv"), String::new())];
            write_design(folder.path(), &files.map(|(path, text)| (at(path), text))).expect("a design");
        };
        fs::create_dir(at("rtl")).expect("a folder");
        fs::write(at("rtl/own.sv"), "").expect("a file of the user");
        ["old", "new", "new"].into_iter().for_each(write);
        assert_eq!(["old", "new", "own"].map(|name| at(&format!("rtl/{name}.sv")).exists()), [false, true, true]);
    }

    #[test]
    fn an_error_between_renames_says_how_many_files_are_new() {
        let folder = tempfile::tempdir().expect("a folder");
        let inside = folder.path().join("both/inside");
        // The second file has the name of the first one's folder.
        let files = [(inside.clone(), "new"), (folder.path().join("both"), "new")];
        let message = write_all(&files).expect_err("a folder is there").to_string();
        assert!(message.ends_with("; 1 of 2 files are written, expected all"), "{message}");
        assert_eq!(fs::read_to_string(&inside).expect("the file"), "new");
    }
}
