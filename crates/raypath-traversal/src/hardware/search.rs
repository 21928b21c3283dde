//! Searches as hardware.
//!
//! Everything follows the order of one queue: a turn of a search ([`turns`]) asks for blocks, which wait in the queue of
//! [`fetch`] until they have arrived. [`beats`] takes them: jobs, queries and lists are stored, and vectors become beats of
//! the datapath. [`ranks`] has a rank for each vector, [`list`] keeps the best, and [`results`] computes their distances.
//! What follows the last vector of a list or of a search is a marker in the same queue. So the neighbours of a search
//! depend on neither the memory nor other searches.

mod beats;
mod branches;
mod bursts;
mod engine;
mod fetch;
mod filter;
mod job;
mod list;
mod ranks;
mod results;
mod turns;
mod visit;
mod widen;
mod wiring;

pub(crate) use bursts::WAITING as TURNS_WAITING;
pub use engine::{SearchPorts, search_engine};
pub(crate) use filter::WAITING as FILTER_WAITING;
pub(crate) use list::PER_WORD as LIST_PER_WORD;
pub(crate) use ranks::IN_FLIGHT as RANKS_IN_FLIGHT;
pub(crate) use results::{DIGITS as RESULTS_DIGITS, WAITING as RESULTS_WAITING};
pub(crate) use turns::Phase;
pub(crate) use wiring::Burst;
