use std::ops::Range;
use thiserror::Error;

/// The maximum dimension of vectors.
pub const MAX_DIMENSIONS: usize = 1 << 16;

/// A non-empty list of vectors of one dimension with finite coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Vectors {
    dimensions: usize,
    data: Vec<f32>,
}

/// The true neighbours of a set of queries: the same number for each, nearest first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Neighbours {
    count: usize,
    data: Vec<u32>,
}

/// Numbers that are not valid vectors or neighbours: what was found, and what was expected.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct DataError(pub(crate) String);

impl Vectors {
    /// Vectors of `dimensions` coordinates from their concatenation `data`.
    ///
    /// # Errors
    /// A dimension that is not 1 to [`MAX_DIMENSIONS`]; no vector, a part of one, more than 2³² − 1; a coordinate that
    /// is not finite.
    pub fn new(dimensions: usize, data: Vec<f32>) -> Result<Self, DataError> {
        let fails = |problem: String| Err(DataError(problem));
        if !(1..=MAX_DIMENSIONS).contains(&dimensions) {
            return fails(format!("vectors of {dimensions} dimensions, expected 1 to {MAX_DIMENSIONS}"));
        }
        let (found, count) = (data.len(), data.len() / dimensions);
        if data.is_empty() {
            return fails("0 vectors, expected at least 1".to_string());
        }
        if !found.is_multiple_of(dimensions) {
            return fails(format!("{found} coordinates, expected a multiple of the dimension {dimensions}"));
        }
        if count > u32::MAX as usize {
            return fails(format!("{count} vectors, expected at most {}", u32::MAX));
        }
        if let Some(position) = data.iter().position(|x| !x.is_finite()) {
            let (vector, coordinate, value) = (position / dimensions, position % dimensions, data[position]);
            let expected = "expected a number that is finite in binary32";
            return fails(format!("vector {vector}, coordinate {coordinate}: found {value}, {expected}"));
        }
        Ok(Self { dimensions, data })
    }

    /// The number of vectors, at least 1.
    #[allow(clippy::len_without_is_empty)] // never empty
    pub fn len(&self) -> usize {
        self.data.len() / self.dimensions
    }

    /// The dimension of the vectors, at least 1.
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// All coordinates, vector after vector.
    pub fn data(&self) -> &[f32] {
        &self.data
    }

    /// The vector with this index, or `None` if there is none.
    pub fn get(&self, index: usize) -> Option<&[f32]> {
        let start = index.checked_mul(self.dimensions)?;
        self.data.get(start..start.checked_add(self.dimensions)?)
    }

    /// The first `count` vectors, but at least one and at most all.
    pub fn first(&self, count: usize) -> Self {
        let count = count.clamp(1, self.len());
        Self { dimensions: self.dimensions, data: self.data[..count * self.dimensions].to_vec() }
    }

    /// The vectors with these indices, or `None` if one of them does not exist or there are none.
    pub fn range(&self, indices: Range<usize>) -> Option<Self> {
        let start = indices.start.checked_mul(self.dimensions)?;
        let data = self.data.get(start..indices.end.checked_mul(self.dimensions)?)?;
        (!data.is_empty()).then(|| Self { dimensions: self.dimensions, data: data.to_vec() })
    }

    /// All vectors in order.
    pub fn iter(&self) -> std::slice::ChunksExact<'_, f32> {
        self.data.chunks_exact(self.dimensions)
    }
}

impl Neighbours {
    /// Neighbours from `indices`, with `count` for each query, in a base of `base` vectors.
    ///
    /// # Errors
    /// No neighbours, a number of indices that is not a multiple of `count`, an index that is not in the base.
    pub fn new(count: usize, indices: &[i64], base: usize) -> Result<Self, DataError> {
        if count == 0 || indices.is_empty() {
            return Err(DataError("no neighbours, expected at least 1 for at least 1 query".to_string()));
        }
        if !indices.len().is_multiple_of(count) {
            return Err(DataError(format!("{} neighbours, expected a multiple of {count}", indices.len())));
        }
        let checked = indices.iter().enumerate().map(|(position, &index)| match u32::try_from(index) {
            Ok(known) if (known as usize) < base => Ok(known),
            _ => {
                let (query, rank, last) = (position / count, position % count, base.saturating_sub(1));
                let problem = format!("query {query}, neighbour {rank}: found index {index}, expected 0 to {last}");
                Err(DataError(problem))
            }
        });
        Ok(Self { count, data: checked.collect::<Result<_, _>>()? })
    }

    /// The number of queries, at least 1.
    pub fn queries(&self) -> usize {
        self.data.len() / self.count
    }

    /// The number of neighbours of each query, at least 1.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The neighbours of each query, nearest first.
    pub fn rows(&self) -> std::slice::ChunksExact<'_, u32> {
        self.data.chunks_exact(self.count)
    }
}
