//! Splitting vectors of any dimension into beats.

use crate::binary32::Binary32;
use crate::distance::Beat;
use crate::handle::{Flags, Num};
use thiserror::Error;

/// The reason why two vectors have no distance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum VectorError {
    /// The vectors have different dimensions.
    #[error("a query of {query} dimensions and a candidate of {candidate}, expected as many")]
    Unequal {
        /// Dimensions of the query.
        query: usize,
        /// Dimensions of the candidate.
        candidate: usize,
    },
    /// The vectors have no dimensions.
    #[error("vectors of 0 dimensions, expected at least 1")]
    Empty,
}

impl<const N: usize> Beat<Binary32, N> {
    /// The beats of two vectors, `N` dimensions each. Lanes beyond the end of the vectors are masked off. The last beat
    /// has `reset_accum` set: its result is the distance of the vectors, and the next pair starts at zero.
    ///
    /// ```
    /// use raypath_ops::{Beat, Binary32};
    ///
    /// let beats: Vec<Beat<Binary32, 16>> = Beat::of(&[1.0; 20], &[3.0; 20])?.collect();
    /// assert_eq!(beats.len(), 2);
    /// assert_eq!(beats[1].mask.to_array()[..6], [true, true, true, true, false, false]);
    /// assert!(!bool::from(beats[0].reset_accum) && bool::from(beats[1].reset_accum));
    /// # Ok::<(), raypath_ops::VectorError>(())
    /// ```
    ///
    /// # Errors
    /// Vectors of different dimensions, or of 0 dimensions.
    pub fn of<'v>(query: &'v [f32], candidate: &'v [f32]) -> Result<impl Iterator<Item = Self> + 'v, VectorError> {
        if query.len() != candidate.len() {
            return Err(VectorError::Unequal { query: query.len(), candidate: candidate.len() });
        }
        if query.is_empty() {
            return Err(VectorError::Empty);
        }
        let last = (query.len() - 1) / N;
        let beats = query.chunks(N).zip(candidate.chunks(N)).enumerate();
        Ok(beats.map(move |(index, (a, b))| Self {
            a: lanes(a),
            b: lanes(b),
            mask: Flags::new(std::array::from_fn(|lane| lane < a.len())),
            reset_accum: (index == last).into(),
        }))
    }
}

fn lanes<const N: usize>(chunk: &[f32]) -> [Num<Binary32>; N] {
    std::array::from_fn(|lane| chunk.get(lane).copied().unwrap_or(0.0).into())
}
