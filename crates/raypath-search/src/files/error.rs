use std::fmt::Display;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A file that cannot be read, or whose content is not valid. The message begins with the path.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{}: {problem}", file.display())]
pub struct FileError {
    /// The file.
    pub file: PathBuf,
    /// The position in the file, what was found there, and what was expected.
    pub problem: String,
}

impl FileError {
    pub(super) fn content(file: &Path, position: impl Display, found: impl Display, expected: impl Display) -> Self {
        Self::of(file)(format!("{position}: found {found}, expected {expected}"))
    }

    /// Converts another error of a file.
    pub(super) fn of<E: Display>(file: &Path) -> impl Fn(E) -> Self {
        move |error| Self { file: file.to_owned(), problem: error.to_string() }
    }
}
