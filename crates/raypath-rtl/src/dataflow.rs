//! The dataflow of an operation as the elaborator records it: a graph of values, for tools that change or evaluate it.

pub use crate::ir::graph::{Kind, Node, NodeId, Op, OperationGraph, OutputValue, PortBit, StateValue};
pub use crate::ir::position::Stage;
use crate::ir::recorder::{self, Marks};
use raypath_ops::Operation;

/// The dataflow of an operation, under opcode 0 and with the stages that it marks. Operands come before their readers.
pub fn record(operation: &impl Operation) -> OperationGraph {
    recorder::record(operation, 0, Marks::Used)
}
