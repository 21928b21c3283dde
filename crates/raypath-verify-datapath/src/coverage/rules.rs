//! The rules of `docs/reference` that a job exercises. This code decides what is counted, not what is right.

mod added;
mod beats;
mod boxes;
mod job;
mod quantised;
mod rounded;
mod triangles;

pub use beats::AccumulatorState;
pub use job::{Job, Rule};

use raypath_rtl::Semantics;

/// What a job can exercise that is known when it enters, and which of the [`numbered`] points.
pub fn rules_at_entry(job: &Job<'_>) -> (Vec<Rule>, Vec<usize>) {
    match job.name {
        "triangle" => (triangles::rules(job), Vec::new()),
        "quadbox" | "octbox" => boxes::rules(job),
        "quantised_box" => quantised::rules(job),
        "euclidean" | "angular" => beats::rules_at_entry(job),
        "key_compare" => added::keys(job),
        "point_in_box" => added::points(job),
        "sphere" => (added::spheres(job), Vec::new()),
        _ => (Vec::new(), Vec::new()),
    }
}

/// The names of points of which a job covers one or several by number: the order of boxes, the child of a key, the
/// accumulator of a beat.
pub fn numbered(operation: &str, semantics: Semantics) -> Vec<String> {
    match operation {
        "quadbox" | "quantised_box" => {
            (0..boxes::PERMUTATIONS).map(|number| format!("5: order {:?}", boxes::permutation(number))).collect()
        }
        "octbox" => (0..64).map(|number| format!("5: box {} at place {}", number / 8, number % 8)).collect(),
        "key_compare" => (0..=added::SEPARATORS).map(|child| format!("child {child}")).collect(),
        "euclidean" | "angular" => {
            let count = semantics.features.accumulators.count();
            (0..if count > 1 { count } else { 0 }).map(|number| format!("accumulator {number}")).collect()
        }
        _ => Vec::new(),
    }
}

/// What a job can exercise that is known only when it leaves: the accumulator that a beat finds, and the exceptions.
pub fn rules_at_exit(
    operation: &str,
    semantics: Semantics,
    found: AccumulatorState,
    exceptions: Option<u64>,
) -> Vec<Rule> {
    let mut rules = match operation {
        "euclidean" | "angular" => beats::rules_at_exit(semantics, found),
        _ => Vec::new(),
    };
    let computes = !["key_compare", "point_in_box"].contains(&operation);
    if let Some(raised) = exceptions {
        let names = ["inexact", "underflow", "overflow", "invalid"];
        let bits = names.iter().enumerate().map(|(bit, name)| Rule::new(*name, raised >> bit & 1 == 1));
        rules.extend(bits.map(|rule| rule.impossible_if(!computes)));
        rules.push(Rule::new("no exception", raised == 0));
    }
    rules
}
