//! Searches: the address of a job goes in, the nearest vectors come out.
//!
//! [`SearchJob`] is a job and its layout in memory. [`search()`] is the functional model: what the unit reads, and the
//! neighbours that it returns, in order. [`SearchImage`] places vectors, graphs and jobs in memory.

mod distance;
mod image;
mod job;
mod list;
mod model;
mod parameters;
mod rank;
mod tree;

pub use distance::{Elements, VectorLayout, dot_product, squared};
pub(crate) use distance::{Shape, sums};
pub use image::{ImageError, SearchImage};
pub use job::{JOB_BYTES, JobError, ParseSearchMetricError, Place, SearchJob, SearchMetric};
pub use model::{Neighbour, SearchCounts, SearchReply, SearchStatus, search};
pub use parameters::{ParseSearchesError, SearchParameters, Searches};
pub(crate) use rank::{distance_of, key_of, rank_of, rank_of_key};
pub(crate) use tree::{BOXES_OPCODE, BRANCHES, Branch, KEYS_OPCODE, NODE_BLOCKS, SEPARATORS};
pub use tree::{NODE_BYTES, order_of_boxes};

/// Bytes of a block, which the unit reads at once.
pub const SEARCH_BLOCK: u32 = 64;
