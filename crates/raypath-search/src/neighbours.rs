use thiserror::Error;

/// The true neighbours of a set of queries: as many for each, nearest first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Neighbours {
    count: usize,
    data: Vec<u32>,
}

/// Why numbers are not the neighbours of queries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum NeighboursError {
    /// There are none.
    #[error("no neighbours, expected at least 1 for at least 1 query")]
    Empty,
    /// The numbers do not fill the last query's.
    #[error("{found} neighbours, expected a multiple of {count}")]
    Ragged {
        /// How many numbers.
        found: usize,
        /// Neighbours of a query.
        count: usize,
    },
    /// An index beyond the base.
    #[error("query {query}, neighbour {rank}: found index {index}, expected 0 to {last}")]
    Index {
        /// The query, from 0.
        query: usize,
        /// The neighbour, from 0.
        rank: usize,
        /// The index.
        index: i64,
        /// The greatest index that the base has.
        last: usize,
    },
}

impl Neighbours {
    /// Neighbours of queries one after another in `indices`, `count` for each, in a base of `base` vectors.
    ///
    /// # Errors
    /// No neighbours, a part of those of a query, an index that the base does not have.
    pub fn new(count: usize, indices: &[i64], base: usize) -> Result<Self, NeighboursError> {
        if count == 0 || indices.is_empty() {
            return Err(NeighboursError::Empty);
        }
        if !indices.len().is_multiple_of(count) {
            return Err(NeighboursError::Ragged { found: indices.len(), count });
        }
        let checked = indices.iter().enumerate().map(|(place, &index)| match u32::try_from(index) {
            Ok(known) if (known as usize) < base => Ok(known),
            _ => {
                let (query, rank) = (place / count, place % count);
                Err(NeighboursError::Index { query, rank, index, last: base.saturating_sub(1) })
            }
        });
        Ok(Self { count, data: checked.collect::<Result<_, _>>()? })
    }

    /// How many queries: at least 1.
    pub fn queries(&self) -> usize {
        self.data.len() / self.count
    }

    /// Neighbours of each query: at least 1.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The neighbours of each query, nearest first.
    pub fn rows(&self) -> std::slice::ChunksExact<'_, u32> {
        self.data.chunks_exact(self.count)
    }
}
