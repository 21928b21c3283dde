use crate::vectors::VectorsError;
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
    /// An integer parameter is out of range.
    #[error("{name} is {found}, expected {expected}")]
    Parameter {
        /// The name of the parameter.
        name: &'static str,
        /// The value.
        found: usize,
        /// The valid range.
        expected: &'static str,
    },
    /// The truth has another number of queries, or too few neighbours.
    #[error("truth of {found} {what}, expected {expected}")]
    Truth {
        /// The item whose number is wrong.
        what: &'static str,
        /// The number found.
        found: usize,
        /// The number expected.
        expected: usize,
    },
    /// A floating-point parameter is out of range.
    #[error("{name} is {found}, expected {expected}")]
    Number {
        /// The name of the parameter.
        name: &'static str,
        /// The value.
        found: f32,
        /// The valid range.
        expected: &'static str,
    },
    /// Threads could not be started.
    #[error("{requested} threads: {reason}")]
    Threads {
        /// The number of requested threads.
        requested: usize,
        /// The reason from the operating system.
        reason: String,
    },
    /// A list of vectors is invalid.
    #[error(transparent)]
    Vectors(#[from] VectorsError),
    /// Two vectors have different dimensions or none.
    #[error(transparent)]
    Vector(#[from] VectorError),
    /// The progress callback returned false.
    #[error("stopped")]
    Stopped,
}
