//! Specifications and tests of operations: stimuli, oracles, exact arithmetic, and checks.
//!
//! An [`OperationSpec`] combines an operation with random jobs and an oracle. An oracle checks results by exact
//! arithmetic or by counting, not by the equations of the operation. [`added_operations`] lists the specifications of
//! the operations in [`raypath_ops::operations`]; each has a file in [`operations`]. [`Checks`] compares the operations
//! of a datapath with their oracles, the netlist with the models, and the SystemVerilog in Verilator with both.
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
pub mod operations;
pub mod slabs;
mod spec;
#[cfg(test)]
mod test_support;

pub use checks::{Checks, OracleReport, Simulated};
pub use operations::{added_operation, added_operations};
pub use spec::{AnyOperationSpec, OperationSpec, jobs};
