//! The recorded window in the form that the page's script reads.

use super::recording::{JobTrace, Recording, Span, Window};
use serde::Serialize;
use serde_json::json;

/// A job: opcode, owner, cycle of acceptance, cycles in each stage reached, whether it left. The list is null if the
/// job spent one cycle in each stage and left, as most do.
#[derive(Serialize)]
struct Trace(usize, u64, u64, Option<Vec<u64>>, bool);

/// The window as JSON for a `script` element: `<`, with which an element or comment starts, is escaped.
pub fn json(recording: &Recording) -> String {
    let Window { owner, first, end, stages, jobs, refused, stalled } = &recording.window;
    let jobs: Vec<Trace> = jobs.iter().map(|job| trace(job, *stages, *end)).collect();
    let timeline = json!({
        "operations": recording.operations, "owner": owner, "first": first, "end": end, "stages": stages,
        "jobs": jobs, "refused": pairs(refused), "stalled": pairs(stalled),
    });
    timeline.to_string().replace('<', "\\u003c")
}

fn trace(job: &JobTrace, stages: usize, end: u64) -> Trace {
    let stays: Vec<u64> = job.stays(end).map(|(from, until)| until.saturating_sub(from)).collect();
    let flows = job.left.is_some() && stays.len() == stages && stays.iter().all(|cycles| *cycles == 1);
    Trace(job.operation, job.owner, job.accepted, (!flows).then_some(stays), job.left.is_some())
}

fn pairs(spans: &[Span]) -> Vec<(u64, u64)> {
    spans.iter().map(|span| (span.from, span.cycles)).collect()
}
