//! Vectors and neighbours from files, and to them.

mod error;
mod hdf5;
mod npy;
mod texmex;
mod write;

pub use error::FileError;
pub use write::{write_fvecs, write_ivecs};

use crate::metric::Metric;
use crate::neighbours::Neighbours;
use crate::vectors::Vectors;
use std::path::Path;

/// What a search needs.
#[derive(Debug, Clone, PartialEq)]
pub struct Dataset {
    /// The vectors that are searched.
    pub base: Vectors,
    /// The vectors that are searched for, of the base's dimension.
    pub queries: Vectors,
    /// The true neighbours of each query, where they are known.
    pub truth: Option<Neighbours>,
    /// The distances of those neighbours, where the file has them.
    pub distances: Option<Vectors>,
    /// The distance that the truth is about, where the file says it.
    pub metric: Option<Metric>,
}

impl Dataset {
    /// Reads what a search needs: all from one `.hdf5` file as ann-benchmarks has them, or from a file each. `queries` and
    /// `truth` take the place of what is in an `.hdf5` file, whose truth is not about other queries than its own.
    ///
    /// # Errors
    /// A file that cannot be read or does not hold what it should ([`FileError`]); queries of another dimension than the
    /// base; truth for another number of queries.
    pub fn read(base: &Path, queries: Option<&Path>, truth: Option<&Path>) -> Result<Self, FileError> {
        let mut dataset = if extension(base) == "hdf5" {
            hdf5::dataset(base, queries.is_none(), queries.is_none() && truth.is_none())?
        } else {
            hdf5::Parts { base: read_vectors(base)?, queries: None, truth: None, distances: None, metric: None }
        };
        if let Some(queries) = queries {
            dataset.queries = Some(read_vectors(queries)?);
        }
        let Some(own_queries) = dataset.queries else {
            return Err(FileError::content(base, "queries", "no file of queries", "one, or an .hdf5 file"));
        };
        if own_queries.dimensions() != dataset.base.dimensions() {
            let expected = format!("{} as {} has", dataset.base.dimensions(), base.display());
            let file = queries.unwrap_or(base);
            return Err(FileError::content(file, "dimensions of the queries", own_queries.dimensions(), expected));
        }
        if let Some(truth) = truth {
            dataset.truth = Some(read_neighbours(truth, dataset.base.len())?);
        }
        if let Some(neighbours) = &dataset.truth
            && neighbours.queries() != own_queries.len()
        {
            let expected = format!("{}, one for each query", own_queries.len());
            let file = truth.unwrap_or(base);
            return Err(FileError::content(file, "rows of neighbours", neighbours.queries(), expected));
        }
        Ok(Self {
            base: dataset.base,
            queries: own_queries,
            truth: dataset.truth,
            distances: dataset.distances,
            metric: dataset.metric,
        })
    }
}

/// Reads vectors from `.fvecs`, `.bvecs`, `.ivecs`, `.npy`, or from the base (`train`) of an `.hdf5` file. Numbers of other
/// types are rounded to binary32.
///
/// # Errors
/// A file that cannot be read, or that holds anything but vectors of one dimension with finite coordinates.
pub fn read_vectors(file: &Path) -> Result<Vectors, FileError> {
    let (dimensions, data) = match extension(file).as_str() {
        "fvecs" => texmex::read(file, f32::from_le_bytes)?,
        "bvecs" => texmex::read(file, |[byte]: [u8; 1]| f32::from(byte))?,
        "ivecs" => texmex::read(file, |bytes| i32::from_le_bytes(bytes) as f32)?,
        "npy" => npy::vectors(file)?,
        "hdf5" => return Ok(hdf5::dataset(file, false, false)?.base),
        other => return Err(unknown(file, other, "fvecs, bvecs, ivecs, npy or hdf5")),
    };
    Vectors::new(dimensions, data).map_err(|source| FileError::Vectors { file: file.to_owned(), source })
}

/// Reads true neighbours in a base of `base` vectors from `.ivecs`, `.npy`, or from `neighbors` of an `.hdf5` file.
///
/// # Errors
/// A file that cannot be read, or that holds anything but indices of the base, as many in each row.
pub fn read_neighbours(file: &Path, base: usize) -> Result<Neighbours, FileError> {
    let (count, indices) = match extension(file).as_str() {
        "ivecs" => texmex::read(file, |bytes| i64::from(i32::from_le_bytes(bytes)))?,
        "npy" => npy::indices(file)?,
        "hdf5" => hdf5::neighbours(file)?,
        other => return Err(unknown(file, other, "ivecs, npy or hdf5")),
    };
    neighbours(file, count, &indices, base)
}

fn neighbours(file: &Path, count: usize, indices: &[i64], base: usize) -> Result<Neighbours, FileError> {
    Neighbours::new(count, indices, base).map_err(|source| FileError::Neighbours { file: file.to_owned(), source })
}

/// The extension in small letters; `h5` is `hdf5`.
fn extension(file: &Path) -> String {
    let extension = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if extension == "h5" { "hdf5".to_owned() } else { extension }
}

fn unknown(file: &Path, extension: &str, expected: &str) -> FileError {
    FileError::content(file, "the name's extension", format_args!("`{extension}`"), expected)
}
