use thiserror::Error;

/// The true neighbours of a set of queries: the same number for each, nearest first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Neighbours {
    count: usize,
    data: Vec<u32>,
}

/// The reason why indices are not valid neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum NeighboursError {
    /// There are no neighbours.
    #[error("no neighbours, expected at least 1 for at least 1 query")]
    Empty,
    /// The last query has too few neighbours.
    #[error("{found} neighbours, expected a multiple of {count}")]
    Ragged {
        /// The number of indices.
        found: usize,
        /// The number of neighbours per query.
        count: usize,
    },
    /// An index is not in the base.
    #[error("query {query}, neighbour {rank}: found index {index}, expected 0 to {last}")]
    Index {
        /// The query, from 0.
        query: usize,
        /// The neighbour, from 0.
        rank: usize,
        /// The index.
        index: i64,
        /// The greatest index of the base.
        last: usize,
    },
}

impl Neighbours {
    /// Neighbours from `indices`, with `count` for each query, in a base of `base` vectors.
    ///
    /// # Errors
    /// No neighbours, a number of indices that is not a multiple of `count`, an index that is not in the base.
    pub fn new(count: usize, indices: &[i64], base: usize) -> Result<Self, NeighboursError> {
        if count == 0 || indices.is_empty() {
            return Err(NeighboursError::Empty);
        }
        if !indices.len().is_multiple_of(count) {
            return Err(NeighboursError::Ragged { found: indices.len(), count });
        }
        let checked = indices.iter().enumerate().map(|(position, &index)| match u32::try_from(index) {
            Ok(known) if (known as usize) < base => Ok(known),
            _ => {
                let (query, rank) = (position / count, position % count);
                Err(NeighboursError::Index { query, rank, index, last: base.saturating_sub(1) })
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
