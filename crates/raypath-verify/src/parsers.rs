//! Robustness of all parsers: they run on the files of `fuzz/corpus`, and on copies with bytes flipped, removed,
//! repeated and joined. libFuzzer calls the same functions ([`TARGETS`]) in `fuzz`.

mod damage;
mod targets;
mod worker;

pub use targets::{TARGETS, Target};

use crate::files::in_folder;
use crate::{Error, Progress, Request, Verdict};
use raypath_tools::read;
use serde::{Deserialize, Serialize};
use std::path::Path;
use worker::{Outcome, Worker};

/// The time limit for an input of some kilobytes, on a busy machine.
const MAX_SECONDS: u64 = 10;
/// The limit on additional memory.
const MAX_BYTES: u64 = 256 << 20;
const FAILURES_SHOWN: usize = 10;

/// Runs each parser on the files of its corpus and on mutations of them.
///
/// # Errors
/// The corpus is missing, because the repository is not where `raypath` was built.
pub fn run(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let mutations = request.jobs.unwrap_or(request.level.pick(1_000, 100_000, 1_000_000));
    let corpora = TARGETS.iter().map(corpus).collect::<Result<Vec<_>, _>>()?;
    let total = corpora.iter().map(|files| files.len() as u64 * (mutations + 1)).sum();
    let mut is_stopped = false;
    let (shard, seed) = (request.shard, request.seed);
    let shards = request.parts.phase(|| {
        let mut tally = Tally::default();
        let before = peak_memory();
        for (target, files) in TARGETS.iter().zip(&corpora) {
            let mut worker = Worker::start(*target, files.clone(), mutations, seed, shard);
            loop {
                match worker.wait(MAX_SECONDS) {
                    Outcome::Busy => {}
                    Outcome::Done => break,
                    Outcome::Failed(failure) => {
                        tally.failures.push(format!("{}: {failure}", target.name));
                        break;
                    }
                }
                if !(request.proceed)(Progress { done: tally.done + worker.done(), total }) {
                    is_stopped = true;
                    worker.stop();
                    break;
                }
            }
            tally.done += worker.done();
            tally.accepted += worker.accepted();
            if is_stopped || tally.failures.len() >= FAILURES_SHOWN {
                break;
            }
        }
        let additional = before.zip(peak_memory()).map(|(before, after)| after.saturating_sub(before));
        tally.is_measured = additional.is_some();
        if let Some(bytes) = additional.filter(|&bytes| bytes > MAX_BYTES) {
            tally.failures.push(format!("{} MiB of additional memory, expected at most 256", bytes >> 20));
        }
        Ok::<_, Error>(tally)
    })?;
    let mut verdict = Verdict { is_stopped, ..Verdict::default() };
    if !shards.iter().all(|shard| shard.is_measured) {
        verdict.remarks.push("memory was not measured: this system does not report it".to_string());
    }
    let done: u64 = shards.iter().map(|shard| shard.done).sum();
    let accepted: u64 = shards.iter().map(|shard| shard.accepted).sum();
    let files = corpora.iter().map(Vec::len).sum::<usize>();
    let formats = TARGETS.len();
    verdict.covered = format!("{done} inputs from {files} files in {formats} formats, {accepted} of them accepted");
    verdict.failures = shards.into_iter().flat_map(|shard| shard.failures).collect();
    Ok(verdict)
}

/// The counts of a shard.
#[derive(Default, Serialize, Deserialize)]
struct Tally {
    done: u64,
    accepted: u64,
    failures: Vec<String>,
    /// Whether the system reports the memory in use.
    is_measured: bool,
}

/// The files of a target's corpus, in the order of their names.
///
/// # Errors
/// A file cannot be read.
pub fn corpus(target: &Target) -> Result<Vec<Vec<u8>>, Error> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus").join(target.name);
    Ok(in_folder(&folder)?.iter().map(|path| read(path)).collect::<Result<_, _>>()?)
}

/// The peak resident memory of this process in bytes, if the system reports it (Linux: `VmHWM`).
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? << 10)
}

#[cfg(test)]
mod tests {
    #[test]
    #[cfg(target_os = "linux")]
    fn a_large_allocation_shows() {
        // More than other tests of this process use. The peak before it says nothing, because they free memory.
        let large = vec![1_u8; 1 << 30];
        let peak = super::peak_memory().expect("a number");
        assert!(large.iter().step_by(4096).all(|&byte| byte == 1) && peak >= 1 << 30, "{peak}");
    }
}
