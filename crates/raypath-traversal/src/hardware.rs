//! The unit as a netlist.

mod axi;
mod blocks;
mod candidates;
mod channels;
mod connect;
mod contexts;
mod decoder;
mod distance;
mod division;
mod entries;
mod files;
mod filled;
mod hits;
mod issue;
mod jobs;
mod names;
mod package;
mod parameters;
mod parametric;
mod properties;
mod queue;
mod rays;
mod registers;
mod scheduler;
mod search;
mod set_up;
mod shared;
mod step;
mod structured;
mod top;
mod walk;
mod weights;

pub(crate) use decoder::LATENCY as DECODER_LATENCY;
pub use names::UnitParameter;
pub use parameters::{UnitParameters, UnitParametersError};
pub(crate) use search::{
    Burst, FILTER_WAITING, LIST_PER_WORD, Phase, RANKS_IN_FLIGHT, RESULTS_DIGITS, RESULTS_WAITING, TURNS_WAITING,
};
pub use search::{SearchPorts, search_engine};
pub use top::{UnitNetlist, fixed_parameters};
