//! Specifications and tests of operations: stimuli, oracles and checks.
//!
//! [`exact::Oracle`] computes the outcome of every operation of the project by the text of `docs/reference`, and
//! [`stimuli`] has random jobs for them. An [`OperationSpec`] combines any operation with random jobs and an oracle.
//! [`added_operations`] lists the specifications of the operations in [`raypath_ops::operations`]. [`Checks`] compares
//! the operations of a datapath with their oracles, the netlist with the models, and the SystemVerilog in Verilator
//! with both.
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
pub mod exact;
#[cfg(feature = "geometry")]
pub mod geometry;
pub mod layout;
mod operations;
mod spec;
pub mod stimuli;

pub use checks::{Checks, OracleReport, Simulated};
pub use operations::{add_operation, added_operation, added_operations};
pub use spec::{AnyOperationSpec, OperationSpec, jobs};
