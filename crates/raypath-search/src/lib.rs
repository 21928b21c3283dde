//! Nearest-neighbour search with the distance operations of the datapath.
//!
//! A vector of any dimension enters the datapath as beats of 16 Euclidean or 8 angular lanes, and leaves as accumulated
//! sums. Square root and division are outside the datapath. [`Exact`] compares a query with every vector. [`UnitJobs`]
//! are jobs for the unit's models, which also search a graph ([`Layer`]). [`Dataset`] reads vectors from files,
//! [`Clusters`] generates them.
//!
//! ```
//! use raypath_search::{Exact, Metric, Vectors};
//!
//! let base = Vectors::new(2, vec![0.0, 0.0, 3.0, 4.0, 1.0, 0.0])?;
//! let queries = Vectors::new(2, vec![0.0, 0.0])?;
//! let results = Exact::new(&base, Metric::Euclidean).search(&queries, 3, &|_| true)?;
//! let distances: Vec<_> = results.rows[0].iter().map(|near| (near.index, near.distance)).collect();
//! assert_eq!(distances, [(0, 0.0), (2, 1.0), (1, 5.0)]);
//! assert_eq!(results.work.beats, 3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod error;
mod exact;
mod files;
mod generated;
mod graph;
mod hnsw;
mod jobs;
mod kernel;
mod layer;
mod metric;
mod recall;
mod results;
mod tree;
mod unit;
mod vectors;

pub use error::SearchError;
pub use exact::Exact;
pub use files::{Dataset, FileError, SavedGraph, read_graph, read_neighbours, read_vectors, write_fvecs, write_ivecs};
pub use generated::Clusters;
pub use graph::GraphParameters;
pub use jobs::distance_jobs;
pub use layer::Layer;
pub use metric::{Metric, ParseMetricError, cosine_distance, euclidean_distance};
pub use raypath_tools::MemoryLimit;
pub use recall::recall;
pub use results::{Neighbour, SearchResults, Work};
pub use unit::{ParseStoredAsError, SearchMemory, StoredAs, UnitJobs, UnitPlace, UnitSearch, UnitSpec, UnitTiming};
pub use vectors::{DataError, MAX_DIMENSIONS, Neighbours, Vectors};
