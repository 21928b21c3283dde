//! What the test of an operation needs: its specification, stimuli, exact arithmetic, and checks.
//!
//! An [`OperationSpec`] joins an operation with random jobs and an oracle. The added operations of
//! [`raypath_ops::operations`] have their specifications in [`operations`], a file each; [`added_operations`] lists
//! them. An oracle decides by exact arithmetic or by counting, not by the operation's own equations. [`Checks`] holds a
//! datapath's operations against their oracles, the models against the netlist, and the emitted text in Verilator
//! against both.
//!
//! ```
//! use raypath_oracle::added_operations;
//! use raypath_sim::Datapath;
//!
//! for spec in added_operations() {
//!     let datapath = Datapath::paper(Default::default()).with_any(spec.operation());
//!     let flip_flops = datapath.elaborate()?.top().register_bits();
//!     println!("with {}: {flip_flops} flip-flops", spec.name());
//! }
//! # assert!(!added_operations().is_empty());
//! # Ok::<(), raypath_rtl::Error>(())
//! ```

mod checks;
pub mod draw;
pub mod exact;
mod jobs;
pub mod operations;
pub mod slabs;
mod spec;
#[cfg(test)]
mod test_support;

pub use checks::{Checks, OracleReport, Simulated};
pub use jobs::jobs;
pub use operations::added_operations;
pub use spec::{AnyOperationSpec, OperationSpec};
