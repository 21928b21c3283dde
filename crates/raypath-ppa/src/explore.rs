//! Searching a space of configurations for the Pareto front of what meets some goals.

mod fit;
mod front;
mod metric;
mod predictor;
mod report;
mod search;
mod structure;
mod units;

pub use fit::{Predicted, Terms};
pub use metric::{Goal, Metric, Values};
pub use predictor::{Candidate, LinearPredictor, Predictor};
pub use report::{SearchPoint, SearchReport};
pub use search::{Found, Outcome, Search, Status};
pub use structure::Structure;
