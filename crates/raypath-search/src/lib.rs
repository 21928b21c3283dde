//! Nearest-neighbour search whose distances are the datapath's: a vector of any dimension goes in as beats of 16
//! Euclidean or 8 angular lanes, and comes out as the accumulated sums. Square root and division are outside.
//!
//! [`Exact`] looks at every vector, a [`Graph`] at few. [`Dataset`] reads vectors from files, [`Clusters`] makes some.
//!
//! ```
//! use raypath_search::{Exact, Metric, Vectors};
//!
//! let base = Vectors::new(2, vec![0.0, 0.0, 3.0, 4.0, 1.0, 0.0])?;
//! let queries = Vectors::new(2, vec![0.0, 0.0])?;
//! let answers = Exact::<16, 8>::new(&base, Metric::Euclidean).search(&queries, 3, &|_| true)?;
//! let distances: Vec<_> = answers.rows[0].iter().map(|near| (near.index, near.distance)).collect();
//! assert_eq!(distances, [(0, 0.0), (2, 1.0), (1, 5.0)]);
//! assert_eq!(answers.work.beats, 3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod agent;
mod answers;
mod distance;
mod error;
mod exact;
mod files;
mod generated;
mod graph;
mod kernel;
mod metric;
mod nearest;
mod neighbours;
mod recall;
mod speed;
mod timing;
mod vectors;

pub use agent::Walk;
pub use answers::{Answers, Neighbour, Work};
pub use distance::{Angle, Datapath};
pub use error::SearchError;
pub use exact::Exact;
pub use files::{Dataset, FileError, read_neighbours, read_vectors, write_fvecs, write_ivecs};
pub use generated::Clusters;
pub use graph::{Graph, GraphParameters, Log};
pub use metric::{Metric, ParseMetricError, cosine_distance, euclidean_distance};
pub use neighbours::{Neighbours, NeighboursError};
pub use recall::{Report, recall};
pub use speed::{Speed, speed};
pub use timing::{Candidates, Subject, TimingError, sweep_search, time_search};
pub use vectors::{MAX_DIMENSIONS, Vectors, VectorsError};
