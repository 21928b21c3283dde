//! Coverage: which operands, rules of `docs/reference/semantics.md` and handshakes a campaign has exercised.

mod counts;
mod handshakes;
mod model;
mod operands;
mod rules;
mod tracker;

pub use counts::{Counted, Coverage};
pub use handshakes::Handshakes;
pub use model::{CoverageModel, CoveragePoint, JobEnd, JobPath, JobPoints};
pub use tracker::Tracker;
