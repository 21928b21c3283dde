//! Readers and writers of vector files.

mod hdf5;
mod npy;
mod saved_graph;
mod texmex;

use crate::{Layer, Metric, Neighbours, Vectors};
use raypath_tools::MemoryLimit;
pub use saved_graph::{SavedGraph, read_graph};
use std::fmt::Display;
use std::path::{Path, PathBuf};
pub use texmex::{write_fvecs, write_ivecs};
use thiserror::Error;

/// A data set: a base, queries, and the truth if known.
#[derive(Debug, Clone, PartialEq)]
pub struct Dataset {
    /// The vectors to search.
    pub base: Vectors,
    /// The queries, of the dimension of the base.
    pub queries: Vectors,
    /// The true neighbours of each query, if known.
    pub truth: Option<Neighbours>,
    /// The distances of the true neighbours, if the file has them.
    pub distances: Option<Vectors>,
    /// The metric of the truth or of the graph, if the file names it.
    pub metric: Option<Metric>,
    /// The lowest layer of a graph of the base, if the file has one.
    pub layer: Option<Layer>,
}

impl Dataset {
    /// Reads a data set from one `.hdf5` file in the layout of ann-benchmarks, or from separate files; the base may be
    /// a graph ([`read_graph`]) with the extension `.bin`, `.faiss`, `.hnsw` or `.index`. `queries` and `truth` replace
    /// those of an `.hdf5` file; with other queries its truth is ignored.
    ///
    /// # Errors
    /// A file that cannot be read or has wrong content ([`FileError`]); queries of another dimension than the base, but
    /// for ranges of keys, which have two dimensions and the keys one;
    /// truth for another number of queries; a list of vectors or neighbours that takes more memory than `limit`, as in
    /// [`read_vectors`].
    pub fn read(
        base: &Path,
        queries: Option<&Path>,
        truth: Option<&Path>,
        limit: MemoryLimit,
    ) -> Result<Self, FileError> {
        let mut layer = None;
        let separate = |base, metric| hdf5::Parts { base, queries: None, truth: None, distances: None, metric };
        let mut dataset = match extension(base).as_str() {
            "hdf5" => hdf5::dataset(base, queries.is_none(), queries.is_none() && truth.is_none(), limit)?,
            "bin" | "faiss" | "hnsw" | "index" => {
                let graph = read_graph(base, limit)?;
                layer = Some(graph.layer);
                separate(graph.vectors, graph.metric)
            }
            _ => separate(read_vectors(base, limit)?, None),
        };
        if let Some(queries) = queries {
            dataset.queries = Some(read_vectors(queries, limit)?);
        }
        let Some(own_queries) = dataset.queries else {
            let expected = "a file of queries, or an .hdf5 file";
            return Err(FileError::content(base, "queries", "no file of queries", expected));
        };
        let are_ranges = (dataset.base.dimensions(), own_queries.dimensions()) == (1, 2);
        if own_queries.dimensions() != dataset.base.dimensions() && !are_ranges {
            let expected = format!("{} as in {}", dataset.base.dimensions(), base.display());
            let file = queries.unwrap_or(base);
            return Err(FileError::content(file, "dimensions of the queries", own_queries.dimensions(), expected));
        }
        if let Some(truth) = truth {
            dataset.truth = Some(read_neighbours(truth, dataset.base.len(), limit)?);
        }
        if let Some(neighbours) = &dataset.truth
            && neighbours.queries() != own_queries.len()
        {
            let expected = format!("{}, one for each query", own_queries.len());
            let file = truth.unwrap_or(base);
            return Err(FileError::content(file, "rows of neighbours", neighbours.queries(), expected));
        }
        let hdf5::Parts { base, truth, distances, metric, .. } = dataset;
        Ok(Self { base, queries: own_queries, truth, distances, metric, layer })
    }
}

/// Reads vectors from `.fvecs`, `.bvecs`, `.ivecs`, `.npy`, or from the base (`train`) of an `.hdf5` file. Numbers of
/// other types are rounded to binary32.
///
/// # Errors
/// A file that cannot be read, or whose content is not a list of vectors of one dimension with finite coordinates;
/// vectors that take more memory than `limit`: 8 bytes for a coordinate as stored and as searched, and 512 for a vector.
pub fn read_vectors(file: &Path, limit: MemoryLimit) -> Result<Vectors, FileError> {
    let (dimensions, data) = match extension(file).as_str() {
        "fvecs" => texmex::read(file, limit, f32::from_le_bytes)?,
        "bvecs" => texmex::read(file, limit, |[byte]: [u8; 1]| f32::from(byte))?,
        "ivecs" => texmex::read(file, limit, |bytes| i32::from_le_bytes(bytes) as f32)?,
        "npy" => npy::vectors(file, limit)?,
        "hdf5" => return Ok(hdf5::dataset(file, false, false, limit)?.base),
        other => return Err(unknown(file, other, "fvecs, bvecs, ivecs, npy or hdf5")),
    };
    Vectors::new(dimensions, data).map_err(FileError::of(file))
}

/// Reads true neighbours in a base of `base` vectors from `.ivecs`, `.npy`, or from `neighbors` of an `.hdf5` file.
///
/// # Errors
/// A file that cannot be read, or whose content is not indices of the base with the same number in each row; more than
/// `limit` as in [`read_vectors`].
pub fn read_neighbours(file: &Path, base: usize, limit: MemoryLimit) -> Result<Neighbours, FileError> {
    let (count, indices) = match extension(file).as_str() {
        "ivecs" => texmex::read(file, limit, |bytes| i64::from(i32::from_le_bytes(bytes)))?,
        "npy" => npy::indices(file, limit)?,
        "hdf5" => hdf5::neighbours(file, limit)?,
        other => return Err(unknown(file, other, "ivecs, npy or hdf5")),
    };
    neighbours(file, count, &indices, base)
}

/// Checks the memory of vectors or neighbours: of each coordinate the two numbers that are read and searched, and of
/// each vector up to 64 masked coordinates for SIMD, twice.
fn check(file: &Path, rows: u64, columns: u64, limit: MemoryLimit) -> Result<(), FileError> {
    let each = columns.saturating_add(64).saturating_mul(8);
    limit.check(rows, format_args!("vectors of {columns} coordinates"), each).map_err(FileError::of(file))
}

fn neighbours(file: &Path, count: usize, indices: &[i64], base: usize) -> Result<Neighbours, FileError> {
    Neighbours::new(count, indices, base).map_err(FileError::of(file))
}

/// The extension in lower case; `hdf5` for `h5`.
fn extension(file: &Path) -> String {
    let extension = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if extension == "h5" { "hdf5".to_owned() } else { extension }
}

fn unknown(file: &Path, extension: &str, expected: &str) -> FileError {
    FileError::content(file, "extension", format_args!("`{extension}`"), expected)
}

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
    fn content(file: &Path, position: impl Display, found: impl Display, expected: impl Display) -> Self {
        Self::of(file)(format!("{position}: found {found}, expected {expected}"))
    }

    /// Converts another error of a file.
    fn of<E: Display>(file: &Path) -> impl Fn(E) -> Self {
        move |error| Self { file: file.to_owned(), problem: error.to_string() }
    }
}
