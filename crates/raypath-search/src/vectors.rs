use thiserror::Error;

/// The maximum dimension of vectors.
pub const MAX_DIMENSIONS: usize = 1 << 16;

/// A non-empty list of vectors of one dimension with finite coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Vectors {
    dimensions: usize,
    data: Vec<f32>,
}

/// The reason why numbers are not a valid list of vectors.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum VectorsError {
    /// The dimension is out of range.
    #[error("vectors of {found} dimensions, expected 1 to {MAX_DIMENSIONS}")]
    Dimensions {
        /// The dimension.
        found: usize,
    },
    /// The list is empty.
    #[error("0 vectors, expected at least 1")]
    Empty,
    /// There are more vectors than 32-bit indices.
    #[error("{found} vectors, expected at most 4294967295")]
    TooMany {
        /// The number of vectors.
        found: usize,
    },
    /// The last vector is incomplete.
    #[error("{found} coordinates, expected a multiple of the dimension {dimensions}")]
    Ragged {
        /// The number of coordinates.
        found: usize,
        /// The dimension.
        dimensions: usize,
    },
    /// A coordinate is infinite or NaN.
    #[error("vector {vector}, coordinate {coordinate}: found {value}, expected a number that is finite in binary32")]
    NotFinite {
        /// The vector, from 0.
        vector: usize,
        /// The coordinate, from 0.
        coordinate: usize,
        /// The value.
        value: f32,
    },
}

impl Vectors {
    /// Vectors of `dimensions` coordinates from their concatenation `data`.
    ///
    /// # Errors
    /// A dimension that is not 1 to [`MAX_DIMENSIONS`]; no vector, a part of one, more than 2³² − 1; a coordinate that
    /// is not finite.
    pub fn new(dimensions: usize, data: Vec<f32>) -> Result<Self, VectorsError> {
        if !(1..=MAX_DIMENSIONS).contains(&dimensions) {
            return Err(VectorsError::Dimensions { found: dimensions });
        }
        if data.is_empty() {
            return Err(VectorsError::Empty);
        }
        if !data.len().is_multiple_of(dimensions) {
            return Err(VectorsError::Ragged { found: data.len(), dimensions });
        }
        if data.len() / dimensions > u32::MAX as usize {
            return Err(VectorsError::TooMany { found: data.len() / dimensions });
        }
        if let Some(position) = data.iter().position(|x| !x.is_finite()) {
            let (vector, coordinate) = (position / dimensions, position % dimensions);
            return Err(VectorsError::NotFinite { vector, coordinate, value: data[position] });
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

    /// All vectors in order.
    pub fn iter(&self) -> std::slice::ChunksExact<'_, f32> {
        self.data.chunks_exact(self.dimensions)
    }
}
