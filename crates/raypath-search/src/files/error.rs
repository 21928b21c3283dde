use crate::neighbours::NeighboursError;
use crate::vectors::VectorsError;
use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a file did not give what it should.
#[derive(Debug, Error)]
pub enum FileError {
    /// It could not be read.
    #[error("{}: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It holds something else than it should.
    #[error("{}: {place}: found {found}, expected {expected}", file.display())]
    Content {
        /// The file.
        file: PathBuf,
        /// Where.
        place: String,
        /// What is there.
        found: String,
        /// What should be.
        expected: String,
    },
    /// Its numbers are not a set of vectors.
    #[error("{}: {source}", file.display())]
    Vectors {
        /// The file.
        file: PathBuf,
        /// Why.
        source: VectorsError,
    },
    /// Its numbers are not neighbours in the base.
    #[error("{}: {source}", file.display())]
    Neighbours {
        /// The file.
        file: PathBuf,
        /// Why.
        source: NeighboursError,
    },
}

impl FileError {
    pub(super) fn content(file: &Path, place: impl Display, found: impl Display, expected: impl Display) -> Self {
        Self::Content {
            file: file.to_owned(),
            place: place.to_string(),
            found: found.to_string(),
            expected: expected.to_string(),
        }
    }

    pub(super) fn read(file: &Path) -> impl Fn(io::Error) -> Self {
        move |source| Self::Read { file: file.to_owned(), source }
    }
}
