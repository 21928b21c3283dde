use crate::vectors::DataError;
use raypath_ops::VectorError;
use thiserror::Error;

/// The reason why a search failed or stopped.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SearchError {
    /// The queries have another dimension than the base.
    #[error("queries of {queries} dimensions, expected {base} as in the base")]
    Dimensions {
        /// The dimension of the base.
        base: usize,
        /// The dimension of the queries.
        queries: usize,
    },
    /// The number of requested neighbours is out of range.
    #[error("{requested} neighbours requested, expected 1 to {available}, the number of vectors in the base")]
    Neighbours {
        /// The number of requested neighbours.
        requested: usize,
        /// The number of vectors in the base.
        available: usize,
    },
    /// A parameter, the truth or a number of threads cannot be used: what was found, and what was expected.
    #[error("{0}")]
    Parameter(String),
    /// A list of vectors is invalid.
    #[error(transparent)]
    Data(#[from] DataError),
    /// Two vectors have different dimensions or none.
    #[error(transparent)]
    Vector(#[from] VectorError),
    /// The progress callback returned false.
    #[error("stopped")]
    Stopped,
}
