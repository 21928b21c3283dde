use crate::neighbours::NeighboursError;
use crate::vectors::VectorsError;
use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The reason why a file could not be used.
#[derive(Debug, Error)]
pub enum FileError {
    /// The file could not be read.
    #[error("{}: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// The error.
        source: io::Error,
    },
    /// The content is not as expected.
    #[error("{}: {position}: found {found}, expected {expected}", file.display())]
    Content {
        /// The file.
        file: PathBuf,
        /// The position in the file.
        position: String,
        /// The content found.
        found: String,
        /// The content expected.
        expected: String,
    },
    /// The numbers are not a valid list of vectors.
    #[error("{}: {source}", file.display())]
    Vectors {
        /// The file.
        file: PathBuf,
        /// The error.
        source: VectorsError,
    },
    /// The numbers are not valid neighbours.
    #[error("{}: {source}", file.display())]
    Neighbours {
        /// The file.
        file: PathBuf,
        /// The error.
        source: NeighboursError,
    },
}

impl FileError {
    pub(super) fn content(file: &Path, position: impl Display, found: impl Display, expected: impl Display) -> Self {
        Self::Content {
            file: file.to_owned(),
            position: position.to_string(),
            found: found.to_string(),
            expected: expected.to_string(),
        }
    }

    pub(super) fn read(file: &Path) -> impl Fn(io::Error) -> Self {
        move |source| Self::Read { file: file.to_owned(), source }
    }
}
