//! From the stages that operations mark to the steps of the pipeline.
//!
//! A step is what stands between two registers. Where units are combinational every stage is one step. Where they take
//! several, a stage becomes as many steps as its longest chain of units needs: an adder or a multiplier begins at a
//! register and is cut into parts, one a step; comparators are not cut but spread over the steps.

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

/// Rewrites operations so that their values stand in steps, and gives the steps, the input's registers first. Adders and
/// multipliers take `latency` steps, at least 1.
pub fn expand(operations: &[Traced], latency: u32) -> (Vec<Traced>, Vec<Step>) {
    let longest = chain(latency);
    let times: Vec<Vec<Time>> = operations.iter().map(|traced| times(traced, latency, longest)).collect();
    let mut steps = vec![Step { stage: 0, part: 1, parts: 1 }];
    let mut first = vec![0];
    for stage in 1..=STAGES {
        first.push(steps.len() as u32);
        let parts = operations.iter().zip(&times).map(|(traced, times)| parts(traced, times, stage)).max().unwrap_or(1);
        steps.extend((1..=parts).map(|part| Step { stage, part, parts }));
    }
    let rewritten = operations.iter().map(|traced| rewrite(traced, &spread(traced, latency, &steps), &first));
    (rewritten.collect(), steps)
}

/// Where a stage has more steps than an operation's comparators need, they stand as far apart as they can.
fn spread(traced: &Traced, latency: u32, steps: &[Step]) -> Vec<Time> {
    let longest = chain(latency);
    let mut spread = times(traced, latency, longest);
    for chain in (1..longest.min(4)).rev() {
        let times = times(traced, latency, chain);
        for step in steps.iter().filter(|step| step.part == 1 && parts(traced, &times, step.stage) <= step.parts) {
            let here = traced.nodes.iter().zip(&times).enumerate().filter(|(_, (node, _))| node.stage == step.stage);
            here.for_each(|(index, (_, time))| spread[index] = *time);
        }
    }
    spread
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
    /// Comparators one after the other in that step, this one included.
    chained: u32,
}

/// Comparators that fit into one step, one after the other.
fn chain(latency: u32) -> u32 {
    match latency {
        1 => u32::MAX,
        2 => 2,
        _ => 1,
    }
}

/// As soon as possible, with at most `chain` comparators one after the other: operands of the same stage first, those of
/// earlier stages are there from the beginning.
fn times(traced: &Traced, latency: u32, chain: u32) -> Vec<Time> {
    let mut times: Vec<Time> = Vec::with_capacity(traced.nodes.len());
    for (index, node) in traced.nodes.iter().enumerate() {
        let operands = traced.operands(NodeId(index as u32));
        let here = operands.into_iter().filter(|operand| traced.node(*operand).stage == node.stage);
        let ready = here.map(|operand| times[operand.index()]).max_by_key(|time| (time.end, time.chained));
        let Time { end, chained, .. } = ready.unwrap_or_default();
        times.push(match node.op {
            Op::Add(..) | Op::Subtract(..) | Op::Multiply(..) if latency > 1 => {
                let begin = if chained > 0 { end + 1 } else { end };
                // Nothing that costs time follows a unit in its last step.
                Time { begin, end: begin + latency - 1, chained: chain }
            }
            Op::Compare(..) if chained >= chain => Time { begin: end + 1, end: end + 1, chained: 1 },
            Op::Compare(..) => Time { begin: end, end, chained: chained + 1 },
            _ => Time { begin: end, end, chained },
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
        let readers = (0..rewritten.nodes.len() as u32)
            .map(NodeId)
            .filter(|&id| rewritten.operands(id).iter().any(|&o| rewritten.node(o).op == Op::State(state)));
        let read = readers.map(|id| rewritten.node(id).stage).min();
        let written = rewritten.node(written).stage;
        rewritten.states[state].written = written;
        rewritten.states[state].read = read.unwrap_or(written);
    }
    rewritten
}
