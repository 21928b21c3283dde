//! All integration tests of the crate, in one program: it is linked once, and its tests share the cores.

mod campaign;
mod control;
mod coverage;
mod equivalence;
mod geometry;
mod memories;
mod oracle;
mod parsers;
mod parts;
mod plan;
mod unit_campaigns;
mod unit_control;
mod unit_proofs;
mod units;
