//! Descriptions of the stages of an automatic schedule.

use crate::ir::graph::{NodeId, Op, OperationGraph};
use crate::ir::liveness;
use crate::ir::position::{LAST_STAGE, Stage};
use std::borrow::Cow;

/// The greatest number of names in a description.
const MAX_NAMES: usize = 5;

/// The values that each stage computes: their names in the operation's description, or their operators if they have
/// none.
pub fn notes(graph: &OperationGraph<Stage>) -> Vec<(u32, Cow<'static, str>)> {
    let positions = liveness::analyse(graph, LAST_STAGE).into_iter().zip(0..);
    let notes = positions.map(|(values, stage)| (stage, note(graph, &values.made)));
    let notes = notes.filter(|(stage, note)| *stage > 0 && !note.is_empty());
    notes.map(|(stage, note)| (stage, Cow::Owned(note))).collect()
}

fn note(graph: &OperationGraph<Stage>, made: &[NodeId]) -> String {
    let made = made.iter().filter(|&&id| graph.is_computed(id) && !graph.is_movable(id));
    let mut named: Vec<String> = Vec::new();
    let mut counted: Vec<(usize, &'static str)> = Vec::new();
    for &id in made {
        if let Some(name) = &graph.node(id).name {
            let stem = stem(name);
            if !named.contains(&stem) {
                named.push(stem);
            }
        } else if let Some(operator) = operator(&graph.node(id).op) {
            match counted.iter_mut().find(|(_, known)| *known == operator) {
                Some((count, _)) => *count += 1,
                None => counted.push((1, operator)),
            }
        }
    }
    if named.is_empty() {
        named = counted.into_iter().map(|(count, operator)| format!("{count} {operator}")).collect();
    }
    let more = named.len().saturating_sub(MAX_NAMES);
    named.truncate(MAX_NAMES);
    if more > 0 {
        named.push(format!("{more} more"));
    }
    named.join(", ")
}

/// A name without its index and what follows: `relative` for `relative_0_x_min`.
fn stem(name: &str) -> String {
    let is_word = |segment: &&str| segment.parse::<u32>().is_err();
    let words: Vec<&str> = name.split('_').take_while(is_word).collect();
    if words.is_empty() { name.to_string() } else { words.join("_") }
}

fn operator(op: &Op) -> Option<&'static str> {
    match op {
        Op::Add(..) => Some("add"),
        Op::Subtract(..) => Some("subtract"),
        Op::Sum(_) => Some("sum"),
        Op::Multiply(..) => Some("multiply"),
        Op::Negate(..) => Some("negate"),
        Op::Compare(..) => Some("compare"),
        Op::Select(..) => Some("select"),
        _ => None,
    }
}
