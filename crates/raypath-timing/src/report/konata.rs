use super::recording::{JobTrace, Recording};
use std::fmt::Write;

/// The lane of the stages, and the one that is laid over it.
const STAGES: u32 = 0;
const STALLS: u32 = 1;

/// The window as a log in the format of the pipeline viewer Konata (`Kanata 0004`, described in its repository in
/// `docs/kanata-log-format.md`).
///
/// A job is an instruction; its thread is its opcode. Lane 0 has the stages, `in` for the cycle in which it was accepted
/// and `s1`, `s2` and so on; lane 1 has `stall` over the cycles at whose end it did not move on. A job that was not seen
/// leaving does not retire.
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
    // Stable: what belongs to one cycle stays in the order in which it was said.
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
            // In its last cycle it moves, if it has been seen moving.
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

/// A label stands in one column of one line.
fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
