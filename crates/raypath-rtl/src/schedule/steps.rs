//! Divides stages into the steps of the pipeline.
//!
//! A step is the logic between two registers. If units are combinational, every stage is one step. If units have a
//! latency of several steps, a stage has as many steps as its longest chain of units needs: a unit begins at a register
//! and is cut into one part per step.
//!
//! An adder of several terms has a part in each of several stages instead, so units are combinational beside it.

use crate::config::Microarchitecture;
use crate::ir::graph::{Kind, Node, NodeId, Op, OperationGraph, StateValue};
use crate::ir::position::{Stage, Step, StepLabel};
use crate::ir::units::{UnitKind, sum_steps};

/// Assigns the values of the operations to steps. Returns the graphs and the labels of the steps, that of the input's
/// registers first. The pipeline has `stages` stages.
pub fn expand(
    operations: &[OperationGraph<Stage>],
    microarchitecture: Microarchitecture,
    stages: u32,
) -> (Vec<OperationGraph<Step>>, Vec<StepLabel>) {
    let times: Vec<Vec<Time>> = operations.iter().map(|graph| times(graph, microarchitecture)).collect();
    let mut labels = vec![StepLabel { stage: 0, part: 1, parts: 1 }];
    let mut first = vec![0];
    for stage in 1..=stages {
        first.push(labels.len() as u32);
        let parts = operations.iter().zip(&times).map(|(graph, times)| parts(graph, times, Stage(stage)));
        let parts = parts.max().unwrap_or(1);
        labels.extend((1..=parts).map(|part| StepLabel { stage, part, parts }));
    }
    let expanded = operations.iter().zip(&times).map(|(graph, times)| assign(graph, times, &first));
    (expanded.collect(), labels)
}

/// The number of steps that an operation needs in a stage, at least 1.
fn parts(graph: &OperationGraph<Stage>, times: &[Time], stage: Stage) -> u32 {
    let here = graph.nodes.iter().zip(times).filter(|(node, _)| node.position == stage);
    here.map(|(_, time)| time.end + 1).max().unwrap_or(1)
}

/// The steps in which a value is computed, counted from the first step of its stage.
#[derive(Debug, Clone, Copy, Default)]
struct Time {
    /// The step in which its unit begins.
    begin: u32,
    /// The step in which the value is available.
    end: u32,
    /// A unit ends in that step, so that another unit has to begin in the next.
    full: bool,
}

/// The earliest times: after operands of the same stage; operands of earlier stages are available from the beginning.
/// If units have a latency of several steps, no unit follows another one in a step.
fn times(graph: &OperationGraph<Stage>, microarchitecture: Microarchitecture) -> Vec<Time> {
    let (latency, comparator_steps) = (microarchitecture.unit_latency, microarchitecture.comparator_steps());
    let is_divided = latency.is_divided();
    let mut times: Vec<Time> = Vec::with_capacity(graph.nodes.len());
    for (id, node) in graph.ids().zip(&graph.nodes) {
        let operands = graph.operands(id);
        let here = operands.into_iter().filter(|operand| graph.node(*operand).position == node.position);
        let ready = here.map(|operand| times[operand.index()]).max_by_key(|time| (time.end, time.full));
        let Time { end, full, .. } = ready.unwrap_or_default();
        let begin = if full { end + 1 } else { end };
        times.push(match &node.op {
            Op::Add(..) | Op::Subtract(..) if is_divided => Time { begin, end: begin + latency.sums - 1, full: true },
            Op::Multiply(..) if is_divided => Time { begin, end: begin + latency.products - 1, full: true },
            Op::Compare(..) if is_divided => Time { begin, end: begin + comparator_steps - 1, full: true },
            _ => Time { begin: end, end, full },
        });
    }
    times
}

/// Assigns every value to its step. A unit of several parts becomes a chain of values, whose last one has the index of
/// the unit's value. `first` is the first step of each stage.
fn assign(graph: &OperationGraph<Stage>, times: &[Time], first: &[u32]) -> OperationGraph<Step> {
    let step = |node: &Node<Stage>, offset: u32| Step(first[node.position.0 as usize] + offset);
    let last = graph.nodes.iter().zip(times).map(|(node, time)| {
        let (op, name) = (node.op.clone(), node.name.clone());
        Node { op, kind: node.kind, position: step(node, time.end), name }
    });
    let mut nodes: Vec<Node<Step>> = last.collect();
    for (index, (node, time)) in graph.nodes.iter().zip(times).enumerate() {
        if let Op::Sum(terms) = &node.op {
            let (steps, mut op) = (sum_steps(terms.len() as u32), node.op.clone());
            for part in 0..steps - 1 {
                let position = Step(first[(node.position.0 + part + 1 - steps) as usize]);
                let name = node.name.as_ref().map(|name| format!("{name}_part_{}", part + 1));
                nodes.push(Node { op, kind: Kind::Cut(UnitKind::Sum, part), position, name });
                op = Op::Continue(NodeId(nodes.len() as u32 - 1));
            }
            nodes[index].op = op;
        }
        let kind = match node.op {
            Op::Add(..) | Op::Subtract(..) => UnitKind::Add,
            Op::Multiply(..) => UnitKind::Multiply,
            Op::Compare(..) => UnitKind::Compare,
            _ => continue,
        };
        let mut op = node.op.clone();
        for part in 0..time.end - time.begin {
            let name = node.name.as_ref().map(|name| format!("{name}_part_{}", part + 1));
            nodes.push(Node { op, kind: Kind::Cut(kind, part), position: step(node, time.begin + part), name });
            op = Op::Continue(NodeId(nodes.len() as u32 - 1));
        }
        nodes[index].op = op;
    }
    let mut expanded = OperationGraph {
        name: graph.name,
        opcode: graph.opcode,
        nodes,
        inputs: graph.inputs.clone(),
        outputs: graph.outputs.clone(),
        states: Vec::new(),
        notes: graph.notes.clone(),
        is_auto: graph.is_auto,
        counts_exceptions: graph.counts_exceptions,
    };
    let states = graph.states.iter().enumerate().map(|(number, state)| {
        let reads_state =
            |&id: &NodeId| expanded.operands(id).iter().any(|&o| expanded.node(o).op == Op::State(number));
        let read = expanded.ids().filter(reads_state).map(|id| expanded.node(id).position).min();
        let written = expanded.node(state.next).position;
        StateValue { name: state.name.clone(), next: state.next, written, read: read.unwrap_or(written) }
    });
    expanded.states = states.collect();
    expanded
}
