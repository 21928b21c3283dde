use super::recording::{JobTrace, Recording};
use std::fmt::Write;

/// The lane of the stages, and the lane shown over it.
const STAGES: u32 = 0;
const STALLS: u32 = 1;

/// Writes the recorded window as a log for the pipeline viewer Konata, in the format `Kanata 0004` that
/// `docs/kanata-log-format.md` of its repository describes.
///
/// Jobs appear as instructions, with the opcode as thread. Lane 0 has the stages: `in` for the cycle of acceptance,
/// then `s1`, `s2` and so on. Lane 1 has `stall` over the cycles in which the job did not advance. A job retires if the
/// sink took its outcome within the window.
pub fn konata(recording: &Recording) -> String {
    let window = &recording.window;
    let mut events = Vec::new();
    let mut retired = 0;
    for (id, job) in window.jobs.iter().enumerate() {
        let kind = recording.operations.get(job.operation).map_or("job", |name| name.as_str());
        let mut log = Log { id, events: &mut events };
        log.push(job.accepted, format!("I\t{id}\t{id}\t{}", job.operation));
        log.push(job.accepted, format!("L\t{id}\t0\t{}", plain(&format!("{kind} {} {}", window.owner, job.owner))));
        let stalls = job.stalls(window.end);
        log.push(job.accepted, format!("L\t{id}\t1\taccepted in cycle {}, {stalls} cycles stalled", job.accepted));
        log.stages(job, window.end);
        if let Some(left) = job.left {
            log.push(left + 1, format!("R\t{id}\t{retired}\t0"));
            retired += 1;
        }
    }
    // The sort is stable: events of one cycle keep their order.
    events.sort_by_key(|(cycle, _)| *cycle);
    let mut now = window.first;
    let mut log = format!("Kanata\t0004\nC=\t{now}\n");
    for (cycle, event) in events {
        if cycle > now {
            // Writing to a String cannot fail.
            let _ = writeln!(log, "C\t{}", cycle - now);
            now = cycle;
        }
        log.push_str(&event);
        log.push('\n');
    }
    log
}

struct Log<'e> {
    id: usize,
    events: &'e mut Vec<(u64, String)>,
}

impl Log<'_> {
    fn push(&mut self, cycle: u64, line: String) {
        self.events.push((cycle, line));
    }

    fn stages(&mut self, job: &JobTrace, end: u64) {
        let accepted_until = job.entered.first().copied().unwrap_or(end);
        self.stay(STAGES, "in", job.accepted, accepted_until, !job.entered.is_empty());
        for (index, (from, until)) in job.stays(end).enumerate() {
            let over = index + 1 < job.entered.len() || job.left.is_some();
            self.stay(STAGES, &format!("s{}", index + 1), from, until, over);
            // A job advances at the end of its last cycle in a stage.
            let stalled = if over { until.saturating_sub(1) } else { until };
            if stalled > from {
                self.stay(STALLS, "stall", from, stalled, over);
            }
        }
    }

    fn stay(&mut self, lane: u32, name: &str, from: u64, until: u64, over: bool) {
        let id = self.id;
        self.push(from, format!("S\t{id}\t{lane}\t{name}"));
        if over {
            self.push(until, format!("E\t{id}\t{lane}\t{name}"));
        }
    }
}

/// A label without tabs and line breaks, which separate columns and lines.
fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
