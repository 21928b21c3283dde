//! The recorded window in the form that the page's script reads.

use super::recording::{JobTrace, Recording, Span};
use serde::Serialize;

#[derive(Serialize)]
struct Timeline<'r> {
    operations: &'r [String],
    owner: &'r str,
    first: u64,
    end: u64,
    stages: usize,
    jobs: Vec<Trace>,
    refused: Vec<(u64, u64)>,
    stalled: Vec<(u64, u64)>,
}

/// A job: opcode, owner, cycle of acceptance, cycles in each stage reached, whether it left. The list is null if the
/// job spent one cycle in each stage and left, as most do.
#[derive(Serialize)]
struct Trace(usize, u64, u64, Option<Vec<u64>>, bool);

/// The window as JSON for a `script` element: `<`, with which an element or comment starts, is escaped.
pub fn json(recording: &Recording) -> String {
    let window = &recording.window;
    let timeline = Timeline {
        operations: &recording.operations,
        owner: &window.owner,
        first: window.first,
        end: window.end,
        stages: window.stages,
        jobs: window.jobs.iter().map(|job| trace(job, window.stages, window.end)).collect(),
        refused: pairs(&window.refused),
        stalled: pairs(&window.stalled),
    };
    // Serialisation of plain data with string keys does not fail.
    serde_json::to_string(&timeline).unwrap_or_default().replace('<', "\\u003c")
}

fn trace(job: &JobTrace, stages: usize, end: u64) -> Trace {
    let stays: Vec<u64> = job.stays(end).map(|(from, until)| until.saturating_sub(from)).collect();
    let flows = job.left.is_some() && stays.len() == stages && stays.iter().all(|cycles| *cycles == 1);
    Trace(job.operation, job.owner, job.accepted, (!flows).then_some(stays), job.left.is_some())
}

fn pairs(spans: &[Span]) -> Vec<(u64, u64)> {
    spans.iter().map(|span| (span.from, span.cycles)).collect()
}
