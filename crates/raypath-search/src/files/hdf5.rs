//! HDF5 in the layout of ann-benchmarks: base, queries and truth in one file, as the datasets `train`, `test`,
//! `neighbors` and `distances` of two axes, with an attribute `distance` that names the metric.

use super::{FileError, check, neighbours as checked};
use crate::{Metric, Neighbours, Vectors};
use hdf5_pure::{DType, Dataset, Error, File};
use raypath_tools::MemoryLimit;
use std::path::Path;

pub(super) struct Parts {
    pub(super) base: Vectors,
    pub(super) queries: Option<Vectors>,
    pub(super) truth: Option<Neighbours>,
    pub(super) distances: Option<Vectors>,
    pub(super) metric: Option<Metric>,
}

/// Reads the base, and on request the queries and the truth.
pub(super) fn dataset(file: &Path, queries: bool, truth: bool, limit: MemoryLimit) -> Result<Parts, FileError> {
    let hdf5 = &open(file)?;
    let vectors = |name: &str| vectors(file, hdf5, name, limit);
    let base = vectors("train")?;
    let queries = if queries { Some(vectors("test")?) } else { None };
    let names = hdf5.root().datasets().map_err(|error| wrong(file, "file", &error))?;
    let here = |name: &str| truth && names.iter().any(|there| there == name);
    let distances = if here("distances") { Some(vectors("distances")?) } else { None };
    let truth = if here("neighbors") {
        let (count, indices) = indices(file, hdf5, limit)?;
        Some(checked(file, count, &indices, base.len())?)
    } else {
        None
    };
    Ok(Parts { base, queries, truth, distances, metric: metric(file, hdf5)? })
}

/// Reads the number of neighbours per query, and all indices.
pub(super) fn neighbours(file: &Path, limit: MemoryLimit) -> Result<(usize, Vec<i64>), FileError> {
    indices(file, &open(file)?, limit)
}

fn open(file: &Path) -> Result<File, FileError> {
    std::fs::File::open(file).map_err(FileError::of(file))?;
    File::open_streaming(file).map_err(|error| wrong(file, "file", &error))
}

fn vectors(file: &Path, hdf5: &File, name: &str, limit: MemoryLimit) -> Result<Vectors, FileError> {
    let is_float = |kind: &DType| matches!(kind, DType::F32 | DType::F64);
    let (dataset, columns) = table(file, hdf5, name, "numbers", is_float, limit)?;
    let data = dataset.read_f32().map_err(|error| wrong(file, name, &error))?;
    Vectors::new(columns, data).map_err(FileError::of(file))
}

fn indices(file: &Path, hdf5: &File, limit: MemoryLimit) -> Result<(usize, Vec<i64>), FileError> {
    let name = "neighbors";
    let (dataset, columns) = table(file, hdf5, name, "integers", |_| false, limit)?;
    Ok((columns, dataset.read_i64().map_err(|error| wrong(file, name, &error))?))
}

/// The maximum expansion of deflate.
const INFLATION: u64 = 1032;

/// Opens a dataset of two axes, with integers or another `allowed` type, and checks its size and that of a chunk, which
/// may be larger, against the file and the limit.
/// Returns it with its number of columns.
fn table(
    file: &Path,
    hdf5: &File,
    name: &str,
    expected: &str,
    allowed: impl Fn(&DType) -> bool,
    limit: MemoryLimit,
) -> Result<(Dataset, usize), FileError> {
    let fail = |error: Error| wrong(file, name, &error);
    let dataset = hdf5.dataset(name).map_err(fail)?;
    let shape = dataset.shape().map_err(fail)?;
    let &[rows, columns] = shape.as_slice() else {
        return Err(FileError::content(file, name, format_args!("shape {shape:?}"), "two axes: vectors, coordinates"));
    };
    let kind = dataset.dtype().map_err(fail)?;
    let integer = matches!(
        kind,
        DType::I8 | DType::I16 | DType::I32 | DType::I64 | DType::U8 | DType::U16 | DType::U32 | DType::U64
    );
    if !(integer || allowed(&kind)) {
        return Err(FileError::content(file, name, format_args!("type {kind}"), expected));
    }
    let named = |error: FileError| FileError { problem: format!("{name}: {}", error.problem), ..error };
    check(file, rows, columns, limit).map_err(named)?;
    let chunk = dataset.chunk_shape().map_err(fail)?.unwrap_or_default();
    let numbers = chunk.iter().fold(1, |size: u64, side| size.saturating_mul(*side));
    limit.check(numbers, "numbers of a chunk", 8).map_err(FileError::of(file)).map_err(named)?;
    let length = std::fs::metadata(file).map_err(FileError::of(file))?.len();
    let capacity = capacity(&dataset, rows, columns, length).map_err(fail)?;
    let size = dataset.element_size().map_err(fail)?;
    if rows.checked_mul(columns).and_then(|count| count.checked_mul(size)).is_none_or(|bytes| bytes > capacity) {
        let found = format!("{rows} x {columns} of type {kind}");
        return Err(FileError::content(file, name, found, format_args!("what is stored in a file of {length} bytes")));
    }
    Ok((dataset, usize::try_from(columns).unwrap_or(usize::MAX)))
}

/// The maximum uncompressed size in bytes of the stored data of a dataset; 0 if chunks are missing.
fn capacity(dataset: &Dataset, rows: u64, columns: u64, length: u64) -> Result<u64, Error> {
    let Some(chunk) = dataset.chunk_shape()? else { return Ok(length) };
    let chunks = dataset.chunks()?;
    let along = |size: u64, axis: usize| chunk.get(axis).filter(|&&chunk| chunk > 0).map(|&chunk| size.div_ceil(chunk));
    let expected = along(rows, 0).zip(along(columns, 1)).and_then(|(down, across)| down.checked_mul(across));
    if expected != Some(chunks.len() as u64) {
        return Ok(0);
    }
    let stored = chunks.iter().fold(0u64, |sum, chunk| sum.saturating_add(chunk.storage_size)).min(length);
    Ok(if dataset.filters().is_empty() { stored } else { stored.saturating_mul(INFLATION) })
}

fn metric(file: &Path, hdf5: &File) -> Result<Option<Metric>, FileError> {
    let position = "attribute distance";
    let attributes = hdf5.root().attrs().map_err(|error| wrong(file, position, &error))?;
    let Some(value) = attributes.get("distance") else { return Ok(None) };
    let Some(name) = value.as_str() else {
        return Err(FileError::content(file, position, format_args!("{value:?}"), "a string"));
    };
    let metric = name.parse().map_err(|_| FileError::content(file, position, format_args!("`{name}`"), NAMES))?;
    Ok(Some(metric))
}

const NAMES: &str = "euclidean or angular";

fn wrong(file: &Path, position: &str, error: &Error) -> FileError {
    FileError::content(file, position, format_args!("`{error}`"), "HDF5 in the layout of ann-benchmarks")
}
