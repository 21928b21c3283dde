//! Reports of failing episodes.

use super::shrink::{Mismatch, Trace, shrink};
use crate::error::Error;
use crate::files;
use raypath_model::{Model, WordModel, Words};
use raypath_rtl::Config;
use raypath_sim::engine::{CycleEngine, NetlistEngine, observe};
use raypath_sim::traffic::{Traffic, recorded_text};
use raypath_sim::transactions::{Transaction, text};
use std::path::Path;

/// An episode that failed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    /// The episode's number.
    pub episode: u64,
    /// The first difference.
    pub what: String,
}

/// Shrinks a failing trace, writes it as transaction files to `folder`, and returns a message with the command that
/// replays it.
///
/// # Errors
/// A file cannot be written.
pub fn report(
    netlist: &mut NetlistEngine,
    model: &WordModel,
    config: Config,
    trace: Trace,
    failure: &Failure,
    folder: &Path,
) -> Result<String, Error> {
    let (trace, mismatch) = shrink(netlist, model, config, trace);
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
    let options = config.options();
    let command = [command.as_str(), &options].join(" ");
    let Failure { episode, what } = failure;
    let jobs = trace.jobs.len();
    Ok(format!("episode {episode}: {what}\n           shrunk to {jobs} jobs; to replay it: {}", command.trim_end()))
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
