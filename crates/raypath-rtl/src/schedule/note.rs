//! What the stages of an automatic schedule do, in words.

use super::{LAST, is_made};
use crate::graph::{NodeId, Op, Traced};
use crate::liveness;
use std::borrow::Cow;

/// Names that a note lists.
const NAMES: usize = 5;

/// What each stage makes, by the names that the operation gave; by operator where it gave none.
pub fn notes(traced: &Traced) -> Vec<(u32, Cow<'static, str>)> {
    let works = liveness::work(traced, LAST).into_iter().zip(0..);
    let notes = works.map(|(work, stage)| (stage, note(traced, &work.made)));
    let notes = notes.filter(|(stage, note)| *stage > 0 && !note.is_empty());
    notes.map(|(stage, note)| (stage, Cow::Owned(note))).collect()
}

fn note(traced: &Traced, made: &[NodeId]) -> String {
    let made = made.iter().filter(|&&id| is_made(traced, id) && !traced.floats(id));
    let mut named: Vec<String> = Vec::new();
    let mut counted: Vec<(usize, &'static str)> = Vec::new();
    for &id in made {
        if let Some(name) = &traced.node(id).name {
            let stem = stem(name);
            if !named.contains(&stem) {
                named.push(stem);
            }
        } else if let Some(operator) = operator(&traced.node(id).op) {
            match counted.iter_mut().find(|(_, known)| *known == operator) {
                Some((count, _)) => *count += 1,
                None => counted.push((1, operator)),
            }
        }
    }
    if named.is_empty() {
        named = counted.into_iter().map(|(count, operator)| format!("{count} {operator}")).collect();
    }
    let more = named.len().saturating_sub(NAMES);
    named.truncate(NAMES);
    if more > 0 {
        named.push(format!("{more} more"));
    }
    named.join(", ")
}

/// A name without what numbers one of many: `relative_0_x_min` is one of `relative`.
fn stem(name: &str) -> String {
    let is_word = |segment: &&str| segment.parse::<u32>().is_err();
    let words: Vec<&str> = name.split('_').take_while(is_word).collect();
    if words.is_empty() { name.to_string() } else { words.join("_") }
}

fn operator(op: &Op) -> Option<&'static str> {
    match op {
        Op::Add(..) => Some("add"),
        Op::Subtract(..) => Some("subtract"),
        Op::Multiply(..) => Some("multiply"),
        Op::Negate(..) => Some("negate"),
        Op::Compare(..) => Some("compare"),
        Op::Select(..) => Some("select"),
        _ => None,
    }
}
