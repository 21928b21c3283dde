//! HNSW graphs as `hnswlib` and `faiss` save them: the vectors, and the lowest layer.

use super::{FileError, check};
use crate::vectors::MAX_DIMENSIONS;
use crate::{Layer, Metric, Vectors};
use raypath_tools::MemoryLimit;
use std::fmt::Display;
use std::path::Path;

/// Vectors with a graph, read from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct SavedGraph {
    /// The vectors, in the order of their labels.
    pub vectors: Vectors,
    /// The lowest layer.
    pub layer: Layer,
    /// The metric, if the file names it, and the unit's search has its name.
    pub metric: Option<Metric>,
}

/// Reads an index of `hnswlib` (`save_index`, vectors of floats) or an `IndexHNSWFlat` of `faiss` (`write_index`).
/// Labels are 0 to the number of vectors − 1, in any order.
///
/// # Errors
/// A file that cannot be read, is no such index, or has other labels, deleted vectors, or more vectors than fit into
/// `limit`, as for [`read_vectors`](crate::read_vectors).
pub fn read_graph(file: &Path, limit: MemoryLimit) -> Result<SavedGraph, FileError> {
    let length = std::fs::metadata(file).map_err(FileError::of(file))?.len();
    limit.check_bytes("the bytes of a graph", length.into()).map_err(FileError::of(file))?;
    let bytes = std::fs::read(file).map_err(FileError::of(file))?;
    let mut source = Bytes { file, bytes: &bytes, at: 0 };
    if bytes.starts_with(b"IHNf") { faiss(&mut source, limit) } else { hnswlib(&mut source, limit) }
}

/// The layout of hnswlib 0.8 (`saveIndex` in `hnswalg.h`).
fn hnswlib(source: &mut Bytes<'_>, limit: MemoryLimit) -> Result<SavedGraph, FileError> {
    let head = ["offset", "most elements", "elements", "bytes of an element", "offset of labels", "offset of vectors"];
    let mut sizes = [0; 6];
    for (size, what) in sizes.iter_mut().zip(head) {
        *size = source.number::<8>(what)? as usize;
    }
    let [offset, most, count, element, label, vector] = sizes;
    source.skip(4, "levels")?;
    let entry = source.number::<4>("first element")? as u32;
    source.skip(8, "connections")?;
    let degree = source.number::<8>("connections of the lowest layer")? as usize;
    source.skip(24, "parameters")?;
    let dimensions = label.wrapping_sub(vector) / 4;
    let expected_label = dimensions.checked_mul(4).and_then(|bytes| bytes.checked_add(vector));
    let has_sense = offset == 0
        && (1..=most).contains(&count)
        && (1..=MAX_DIMENSIONS).contains(&dimensions)
        && degree.checked_mul(4).and_then(|bytes| bytes.checked_add(4)) == Some(vector)
        && (expected_label, label.checked_add(8)) == (Some(label), Some(element));
    if !has_sense {
        return Err(source.problem("head", "other sizes", "an index of hnswlib or an IndexHNSWFlat of faiss"));
    }
    check(source.file, count as u64, dimensions as u64, limit)?;
    let (mut numbers, mut lists, mut labels) = (Vec::new(), Vec::new(), Vec::new());
    for index in 0..count {
        let what = format!("element {index}");
        let head = source.number::<4>(&what)?;
        if head >> 16 & 1 == 1 {
            return Err(source.problem(&what, "a deleted one", "an index without deleted elements"));
        }
        let links = source.list::<4>(degree, &what)?;
        let used = (head as usize & 0xffff).min(degree);
        lists.push(links.iter().take(used).map(|bytes| u32::from_le_bytes(*bytes)).collect());
        numbers.extend(source.list::<4>(dimensions, &what)?.iter().map(|bytes| f32::from_le_bytes(*bytes)));
        labels.push(source.number::<8>(&what)?);
    }
    for index in 0..count {
        let what = format!("upper layers of element {index}");
        let bytes = source.number::<4>(&what)? as usize;
        source.skip(bytes, &what)?;
    }
    let graph = (degree, lists, entry);
    let (numbers, graph) = by_label(source, dimensions, numbers, graph, &labels)?;
    source.saved(dimensions, numbers, graph, None)
}

/// The layout of faiss 1.7 to 1.15 (`write_HNSW` and `write_index_header` in `index_write.cpp`).
fn faiss(source: &mut Bytes<'_>, limit: MemoryLimit) -> Result<SavedGraph, FileError> {
    let (dimensions, count, metric) = source.faiss_head()?;
    check(source.file, count as u64, dimensions as u64, limit)?;
    source.faiss_list::<8>("probabilities of levels")?;
    let offsets_in_levels = source.faiss_list::<4>("neighbours of levels")?;
    source.faiss_list::<4>("levels")?;
    let offsets = source.faiss_list::<8>("offsets")?;
    let neighbours = source.faiss_list::<4>("neighbours")?;
    let entry = source.number::<4>("first vector")? as u32;
    source.skip(16, "parameters")?;
    let degree = offsets_in_levels.get(1).map_or(0, |bytes| u32::from_le_bytes(*bytes)) as usize;
    let mut lists = Vec::with_capacity(count);
    for index in 0..count {
        let first = offsets.get(index).map_or(usize::MAX, |bytes| u64::from_le_bytes(*bytes) as usize);
        let Some(list) = neighbours.get(first..).and_then(|list| list.get(..degree)) else {
            return Err(source.problem("offsets", format!("offset {first}"), format!("{degree} neighbours there")));
        };
        let list = list.iter().map(|bytes| i32::from_le_bytes(*bytes)).take_while(|next| *next >= 0);
        lists.push(list.map(i32::cast_unsigned).collect());
    }
    let kind = source.take(4, "kind of the vectors")?;
    if ![b"IxF2", b"IxFI", b"IxFl"].iter().any(|flat| kind == *flat) {
        return Err(source.problem("kind of the vectors", String::from_utf8_lossy(kind), "flat ones (IndexHNSWFlat)"));
    }
    if source.faiss_head()? != (dimensions, count, metric) {
        return Err(source.problem("head of the vectors", "another", "the number and dimensions of the graph"));
    }
    let numbers = source.faiss_list::<4>("vectors")?.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
    source.saved(dimensions, numbers, (degree, lists, entry), (metric == 1).then_some(Metric::Euclidean))
}

type Lists = (usize, Vec<Vec<u32>>, u32);

/// Vectors and graph in the order of labels.
fn by_label(
    source: &Bytes<'_>,
    dimensions: usize,
    numbers: Vec<f32>,
    (degree, lists, entry): Lists,
    labels: &[u64],
) -> Result<(Vec<f32>, Lists), FileError> {
    let count = labels.len();
    let mut element_of: Vec<Option<usize>> = vec![None; count];
    for (element, label) in labels.iter().enumerate() {
        match element_of.get_mut(*label as usize) {
            Some(place @ None) => *place = Some(element),
            _ => return Err(source.problem("labels", label, format!("each of 0 to {} once", count - 1))),
        }
    }
    let relabelled = |index: u32| labels.get(index as usize).map_or(index, |label| *label as u32);
    let elements = || element_of.iter().flatten();
    let row = |element: &usize| &numbers[element * dimensions..][..dimensions];
    let ordered = elements().flat_map(row).copied().collect();
    let lists = elements().map(|element| lists[*element].iter().copied().map(relabelled).collect()).collect();
    Ok((ordered, (degree, lists, relabelled(entry))))
}

struct Bytes<'f> {
    file: &'f Path,
    bytes: &'f [u8],
    at: usize,
}

impl<'f> Bytes<'f> {
    fn problem(&self, what: &str, found: impl Display, expected: impl Display) -> FileError {
        FileError::content(self.file, format_args!("byte {}, {what}", self.at), found, expected)
    }

    fn take(&mut self, count: usize, what: &str) -> Result<&'f [u8], FileError> {
        let left = &self.bytes[self.at..];
        let Some(bytes) = left.get(..count) else {
            return Err(self.problem(what, format!("the last {} bytes", left.len()), format!("{count} bytes")));
        };
        self.at += count;
        Ok(bytes)
    }

    fn skip(&mut self, count: usize, what: &str) -> Result<(), FileError> {
        self.take(count, what).map(|_| ())
    }

    fn number<const N: usize>(&mut self, what: &str) -> Result<u64, FileError> {
        Ok(self.take(N, what)?.iter().rev().fold(0, |all, byte| all << 8 | u64::from(*byte)))
    }

    fn list<const N: usize>(&mut self, count: usize, what: &str) -> Result<&'f [[u8; N]], FileError> {
        Ok(self.take(count.saturating_mul(N), what)?.as_chunks::<N>().0)
    }

    /// A list of faiss: its length, and items of `N` bytes.
    fn faiss_list<const N: usize>(&mut self, what: &str) -> Result<&'f [[u8; N]], FileError> {
        let count = self.number::<8>(what)? as usize;
        self.list::<N>(count, what)
    }

    /// The dimensions, the number of vectors and the metric of an index of faiss.
    fn faiss_head(&mut self) -> Result<(usize, usize, u64), FileError> {
        if self.at == 0 {
            self.skip(4, "kind")?;
        }
        let dimensions = self.number::<4>("dimensions")? as usize;
        let count = self.number::<8>("vectors")? as usize;
        self.skip(17, "head")?;
        let metric = self.number::<4>("metric")?;
        if metric > 1 {
            return Err(self.problem("metric", metric, "0 for inner products or 1 for squared distances"));
        }
        Ok((dimensions, count, metric))
    }

    fn saved(
        &self,
        dimensions: usize,
        numbers: Vec<f32>,
        (degree, lists, entry): Lists,
        metric: Option<Metric>,
    ) -> Result<SavedGraph, FileError> {
        let more = self.bytes.len() - self.at;
        if more > 0 {
            return Err(self.problem("after the graph", format!("{more} more bytes"), "the end of the file"));
        }
        let vectors = Vectors::new(dimensions, numbers).map_err(FileError::of(self.file))?;
        if vectors.len() != lists.len() {
            return Err(self.problem("vectors", vectors.len(), format!("{}, as in the graph", lists.len())));
        }
        let layer = Layer::new(degree, lists, entry).map_err(FileError::of(self.file))?;
        Ok(SavedGraph { vectors, layer, metric })
    }
}
