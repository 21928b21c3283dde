//! Reports of failing episodes. A failure is shrunk first: jobs and handshakes are removed while the
//! trace still fails (delta debugging: Zeller and Hildebrandt, IEEE TSE 28(2), 2002).

use crate::datapaths::TestedDatapath;
use raypath_model::{Model, WordModel, Words};
use raypath_sim::engine::{CycleEngine, NetlistEngine, observe};
use raypath_sim::lockstep::{Difference, SideBySide};
use raypath_sim::traffic::{Cycle, Traffic, recorded_text};
use raypath_sim::transactions::{Transaction, text};
use raypath_verify::Error;
use raypath_verify::files;
use std::cell::Cell;
use std::path::Path;

/// Shrinks a failing trace, writes it as transaction files to `folder`, and returns a message with the command that
/// replays it.
///
/// # Errors
/// A file cannot be written.
pub fn report(
    netlist: &mut NetlistEngine,
    model: &WordModel,
    subject: &TestedDatapath,
    trace: Trace,
    folder: &Path,
) -> Result<String, Error> {
    let config = subject.config;
    let (trace, mismatch) = shrink(netlist, model, trace);
    let engine = match mismatch {
        Mismatch::Outcome => "netlist",
        Mismatch::Ports => "both",
    };
    let stream = stream(netlist, model, &trace);
    let mut command = String::from("raypath replay");
    for kind in model.kinds() {
        let of_kind: Vec<Transaction> = stream.iter().filter(|t| t.job.kind() == kind).cloned().collect();
        if !of_kind.is_empty() {
            let path = folder.join(format!("{kind}.txt"));
            files::write(&path, &text(model, kind, &of_kind, config))?;
            command += &format!(" {}", path.display());
        }
    }
    command += &format!(" --engine {engine}");
    if !trace.cycles.is_empty() {
        let path = folder.join("handshake.txt");
        files::write(&path, &recorded_text(&trace.cycles))?;
        command += &format!(" --handshake {}", path.display());
    }
    let options = subject.options();
    let command = [command.as_str(), &options].join(" ");
    Ok(format!("shrunk to {} jobs; to replay it: {}", trace.jobs.len(), command.trim_end()))
}

/// The jobs of a trace, with the functional model's outcomes for those that leave the pipeline.
fn stream(netlist: &NetlistEngine, model: &WordModel, trace: &Trace) -> Vec<Transaction> {
    let no_outcome = |job: &Words| model.outcome(job.kind(), |_| 0);
    let numbered = trace.jobs.iter().enumerate();
    let mut stream: Vec<Transaction> = numbered
        .map(|(seq, job)| Transaction { seq: seq as u64, category: 0, job: job.clone(), expected: no_outcome(job) })
        .collect();
    let mut functional = model.clone();
    let mut engine = CycleEngine::new(model.clone(), netlist.shape());
    let mut traffic = Traffic::recorded(trace.cycles.clone());
    observe(&mut engine, trace.jobs.iter(), &mut traffic, |seen| {
        if seen.cycle.resets {
            functional.reset();
        }
        if let Some(transaction) = seen.entered.and_then(|index| stream.get_mut(index)) {
            transaction.expected = functional.run(&transaction.job);
        }
        true
    });
    stream
}

/// Jobs, and the behaviour of source, sink and reset from a new netlist's state on. After the last recorded cycle
/// source and sink are always ready.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// The jobs.
    pub jobs: Vec<Words>,
    /// The cycles.
    pub cycles: Vec<Cycle>,
}

/// How a netlist differs from its models.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mismatch {
    /// An outcome differs from the functional model's.
    Outcome,
    /// A port differs from the cycle-exact model's in some cycle.
    Ports,
}

/// Shrinks a failing trace, and returns how it fails. A wrong outcome stays a wrong outcome. A trace that does not fail
/// is returned unchanged.
fn shrink(netlist: &mut NetlistEngine, model: &WordModel, mut trace: Trace) -> (Trace, Mismatch) {
    let mut fails = |trace: &Trace, mismatch| fails(netlist, model, trace, mismatch);
    let mismatch = if fails(&trace, Mismatch::Outcome) { Mismatch::Outcome } else { Mismatch::Ports };
    if !fails(&trace, mismatch) {
        return (trace, mismatch);
    }
    let mut fails =
        |jobs: &[Words], cycles: &[Cycle]| fails(&Trace { jobs: jobs.to_vec(), cycles: cycles.to_vec() }, mismatch);
    // Fewer jobs can make more cycles superfluous, and the reverse.
    const ROUNDS: usize = 4;
    for _ in 0..ROUNDS {
        let before = (trace.jobs.len(), trace.cycles.len());
        for simpler in simpler_cycles(&trace.cycles) {
            if fails(&trace.jobs, &simpler) {
                trace.cycles = simpler;
                break;
            }
        }
        trace.jobs = reduced(trace.jobs, |jobs| fails(jobs, &trace.cycles));
        trace.cycles = reduced(trace.cycles, |cycles| fails(&trace.jobs, cycles));
        if before == (trace.jobs.len(), trace.cycles.len()) {
            break;
        }
    }
    (trace, mismatch)
}

/// Whether a trace shows this mismatch.
fn fails(netlist: &mut NetlistEngine, model: &WordModel, trace: &Trace, mismatch: Mismatch) -> bool {
    /// An upper bound of a job's cycles after the last recorded cycle.
    const CYCLES_PER_JOB: u64 = 64;
    netlist.restart();
    let worst = Cell::new(None);
    let mut engines = SideBySide::new(netlist, model.clone(), |found| worst.set(worst.get().max(Some(found))));
    let enough = trace.cycles.len() as u64 + CYCLES_PER_JOB * (trace.jobs.len() as u64 + 1);
    let mut cycles = 0;
    let is_seen = || match mismatch {
        Mismatch::Outcome => worst.get() == Some(Difference::Answer),
        Mismatch::Ports => worst.get().is_some(),
    };
    observe(&mut engines, trace.jobs.iter(), &mut Traffic::recorded(trace.cycles.clone()), |_| {
        cycles += 1;
        cycles < enough && !is_seen()
    });
    is_seen()
}

/// Simpler handshakes, the simplest first: none at all, and those without resets, withdrawn jobs, bubbles or stalls.
fn simpler_cycles(cycles: &[Cycle]) -> Vec<Vec<Cycle>> {
    if cycles.is_empty() {
        return Vec::new();
    }
    let with = |change: fn(&mut Cycle)| {
        let mut changed = cycles.to_vec();
        changed.iter_mut().for_each(change);
        changed
    };
    let all = [
        Vec::new(),
        with(|cycle| (cycle.resets, cycle.withdraws) = (false, false)),
        with(|cycle| cycle.withdraws = false),
        with(|cycle| cycle.resets = false),
        with(|cycle| cycle.offers = true),
        with(|cycle| cycle.takes = true),
    ];
    all.into_iter().filter(|changed| changed != cycles).collect()
}

/// Removes chunks of the items, the largest first, while the rest still fails.
pub fn reduced<T: Clone>(mut items: Vec<T>, mut fails: impl FnMut(&[T]) -> bool) -> Vec<T> {
    let mut chunk = items.len();
    while chunk > 0 {
        let mut begin = 0;
        while begin < items.len() {
            let end = (begin + chunk).min(items.len());
            let fewer = [&items[..begin], &items[end..]].concat();
            if fails(&fewer) {
                items = fewer;
            } else {
                begin = end;
            }
        }
        chunk /= 2;
    }
    items
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reduction_keeps_what_matters() {
        let needed = [3, 17, 64];
        let left = reduced((0..100).collect::<Vec<i32>>(), |items| needed.iter().all(|item| items.contains(item)));
        assert_eq!(left, needed);
        assert!(reduced((0..100).collect::<Vec<i32>>(), |_| true).is_empty());
        assert_eq!(reduced((0..10).collect::<Vec<i32>>(), |items| items.len() > 6).len(), 7);
    }
}
