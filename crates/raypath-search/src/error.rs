use crate::vectors::VectorsError;
use raypath_ops::VectorError;
use thiserror::Error;

/// Why a search did not happen, or not to its end.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SearchError {
    /// Queries that are not of the base's dimension.
    #[error("queries of {queries} dimensions, expected {base} as the base has")]
    Dimensions {
        /// Dimension of the base.
        base: usize,
        /// Dimension of the queries.
        queries: usize,
    },
    /// A number of neighbours that the base does not have.
    #[error("{asked} neighbours asked for, expected 1 to {there}, as many as the base has vectors")]
    Neighbours {
        /// How many were asked for.
        asked: usize,
        /// Vectors of the base.
        there: usize,
    },
    /// A parameter out of its range.
    #[error("{name} is {found}, expected {expected}")]
    Parameter {
        /// Its name.
        name: &'static str,
        /// What it was.
        found: usize,
        /// Its range.
        expected: &'static str,
    },
    /// True neighbours for another number of queries, or fewer than are compared.
    #[error("truth of {found} {what}, expected {expected}")]
    Truth {
        /// Of what there are too few or too many.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// A number that a distribution cannot have.
    #[error("{name} is {found}, expected {expected}")]
    Number {
        /// Its name.
        name: &'static str,
        /// What it was.
        found: f32,
        /// Its range.
        expected: &'static str,
    },
    /// No threads could be started.
    #[error("{asked} threads: {why}")]
    Threads {
        /// How many were asked for.
        asked: usize,
        /// What the system says.
        why: String,
    },
    /// Numbers that are not a set of vectors.
    #[error(transparent)]
    Vectors(#[from] VectorsError),
    /// Two vectors that have no distance.
    #[error(transparent)]
    Vector(#[from] VectorError),
    /// The callback said to stop.
    #[error("stopped")]
    Stopped,
}
