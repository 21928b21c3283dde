//! From the stages that operations mark to the steps of the pipeline.
//!
//! A step is what stands between two registers. Where units are combinational every stage is one step. Where they take
//! several, a stage becomes as many steps as its longest chain of units needs: an adder or a multiplier begins at a
//! register and is cut into parts, one a step; a comparator is not cut, and has a step to itself.

use crate::STAGES;
use crate::graph::{Kind, Node, NodeId, Op, Traced};
use crate::units::UnitKind;
use std::fmt;

/// A step of the pipeline: a stage, or a part of one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Step {
    /// The stage of Table VII; 0 for the input's registers.
    pub stage: u32,
    /// Which of the stage's steps, from 1.
    pub part: u32,
    /// How many steps the stage has.
    pub parts: u32,
}

/// `2`, or `2.1` where the stage has several steps; `input` for the input's registers.
impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self { stage: 0, .. } => f.write_str("input"),
            Self { stage, parts: 1, .. } => write!(f, "{stage}"),
            Self { stage, part, .. } => write!(f, "{stage}.{part}"),
        }
    }
}

/// Rewrites operations so that their values stand in steps, and gives the steps, the input's registers first. Adders
/// and multipliers take `latency` steps, at least 1.
pub fn expand(operations: &[Traced], latency: u32) -> (Vec<Traced>, Vec<Step>) {
    let times: Vec<Vec<Time>> = operations.iter().map(|traced| times(traced, latency)).collect();
    let mut steps = vec![Step { stage: 0, part: 1, parts: 1 }];
    let mut first = vec![0];
    for stage in 1..=STAGES {
        first.push(steps.len() as u32);
        let parts = operations.iter().zip(&times).map(|(traced, times)| parts(traced, times, stage)).max().unwrap_or(1);
        steps.extend((1..=parts).map(|part| Step { stage, part, parts }));
    }
    let rewritten = operations.iter().zip(&times).map(|(traced, times)| rewrite(traced, times, &first));
    (rewritten.collect(), steps)
}

/// How many steps an operation needs in a stage, at least 1.
fn parts(traced: &Traced, times: &[Time], stage: u32) -> u32 {
    let here = traced.nodes.iter().zip(times).filter(|(node, _)| node.stage == stage);
    here.map(|(_, time)| time.end + 1).max().unwrap_or(1)
}

/// When a value is made, in steps from the beginning of its stage.
#[derive(Debug, Clone, Copy, Default)]
struct Time {
    /// The step in which its unit begins.
    begin: u32,
    /// The step in which it is there.
    end: u32,
    /// A unit has ended in that step, so that another one has to wait for the next.
    full: bool,
}

/// As soon as possible: operands of the same stage first, those of earlier stages are there from the beginning. Where
/// units take several steps, no unit follows another one in a step.
fn times(traced: &Traced, latency: u32) -> Vec<Time> {
    let mut times: Vec<Time> = Vec::with_capacity(traced.nodes.len());
    for (id, node) in traced.ids().zip(&traced.nodes) {
        let operands = traced.operands(id);
        let here = operands.into_iter().filter(|operand| traced.node(*operand).stage == node.stage);
        let ready = here.map(|operand| times[operand.index()]).max_by_key(|time| (time.end, time.full));
        let Time { end, full, .. } = ready.unwrap_or_default();
        let begin = if full { end + 1 } else { end };
        times.push(match &node.op {
            op if op.rounds() && latency > 1 => Time { begin, end: begin + latency - 1, full: true },
            Op::Compare(..) if latency > 1 => Time { begin, end: begin, full: true },
            _ => Time { begin: end, end, full },
        });
    }
    times
}

/// Puts every value into its step. A unit of several parts becomes a chain of values; the one that others read is last.
fn rewrite(traced: &Traced, times: &[Time], first: &[u32]) -> Traced {
    let mut rewritten = traced.clone();
    for (index, (node, time)) in traced.nodes.iter().zip(times).enumerate() {
        let base = first[node.stage as usize];
        rewritten.nodes[index].stage = base + time.end;
        let kind = match node.op {
            Op::Add(..) | Op::Subtract(..) => UnitKind::Add,
            Op::Multiply(..) => UnitKind::Multiply,
            _ => continue,
        };
        let mut op = node.op.clone();
        for part in 0..time.end - time.begin {
            let name = node.name.as_ref().map(|name| format!("{name}_part_{}", part + 1));
            let stage = base + time.begin + part;
            rewritten.nodes.push(Node { op, kind: Kind::Cut(kind, part), stage, name });
            op = Op::Continue(NodeId(rewritten.nodes.len() as u32 - 1));
        }
        rewritten.nodes[index].op = op;
    }
    for state in 0..traced.states.len() {
        let written = traced.states[state].next;
        let readers = rewritten
            .ids()
            .filter(|&id| rewritten.operands(id).iter().any(|&o| rewritten.node(o).op == Op::State(state)));
        let read = readers.map(|id| rewritten.node(id).stage).min();
        let written = rewritten.node(written).stage;
        rewritten.states[state].written = written;
        rewritten.states[state].read = read.unwrap_or(written);
    }
    rewritten
}
