//! Mutation: whether the everyday tests notice a fault in the netlist.

mod logic;
mod passes;
mod report;
mod sample;
mod trial;
mod units;

use crate::verify::{Error, Level, Request, Verdict};
use raypath_hdl::mutate::{Fault, replace};
use raypath_rtl::{Config, Control, Lanes, UnitLatency};
use report::Report;
use sample::{Subject, choose, subjects};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;
use trial::Trial;

/// The datapaths whose modules get faults: the default, and small ones with the modules that it does not have.
const CONFIGS: [Config; 4] = [
    Config::DEFAULT,
    Config { lanes: Lanes::Two, control: Control::Credit, ..Config::DEFAULT },
    Config { lanes: Lanes::Two, unit_latency: UnitLatency::Two, ..Config::DEFAULT },
    Config { lanes: Lanes::Two, control: Control::Credit, unit_latency: UnitLatency::Two, ..Config::DEFAULT },
];

/// Where the fate of each mutant is written.
const LIST: &str = "build/verify/mutants.txt";

/// Bytes of a thread's stack: proofs descend from the outputs to the inputs.
const STACK: usize = 64 << 20;

/// What became of a mutant.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Fate {
    /// A check failed.
    Killed(&'static str),
    /// No check did, and rightly: this proof says that the fault changes nothing.
    Equivalent(&'static str),
    /// No check did, and this is what a proof came to.
    Survived(&'static str),
}

/// The item `mutation`: faults of every module, each before the checks of the everyday tests.
///
/// # Errors
/// A datapath that cannot be elaborated or compiled, and a list that cannot be written.
pub fn run(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let count = request.jobs.unwrap_or(request.level.pick(60, 2400, 10_000)) as usize;
    let subjects = subjects(&CONFIGS)?;
    let mutants = choose(&subjects, count, request.seed);
    let proves_modules = request.level > Level::Everyday;
    let report = judge(&subjects, &mutants, request, &|trial| trial.run(proves_modules))?;
    report.write(Path::new(LIST))?;
    Ok(report.verdict())
}

/// A fault of a subject.
struct Mutant<'s> {
    subject: &'s Subject,
    fault: &'s Fault,
}

type Judge<'a> = &'a (dyn Fn(&Trial<'_>) -> Result<Fate, Error> + Sync);

/// Lets `judge` decide on each mutant of the shard, on all cores.
fn judge<'s>(
    subjects: &'s [Subject],
    mutants: &[Mutant<'s>],
    request: &mut Request<'_>,
    judge: Judge<'_>,
) -> Result<Report<'s>, Error> {
    let mine: Vec<&Mutant<'_>> =
        mutants.iter().zip(0..).filter(|(_, n)| request.shard.takes(*n)).map(|(m, _)| m).collect();
    let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let (send, receive) = channel();
    let mut report = Report::new(subjects, mine.len());
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            let (send, next, stop, mine) = (send.clone(), &next, &stop, &mine);
            let work = move || {
                while !stop.load(Ordering::Relaxed)
                    && let Some(mutant) = mine.get(next.fetch_add(1, Ordering::Relaxed))
                {
                    let fate = trial(mutant).and_then(|trial| judge(&trial));
                    if send.send(fate.map(|fate| (*mutant, fate))).is_err() {
                        return;
                    }
                }
            };
            let worker = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work);
            worker.map_err(|problem| Error::Program {
                program: "raypath".to_string(),
                problem: format!("no thread: {problem}"),
                expected: "a system that gives threads".to_string(),
            })?;
        }
        drop(send);
        let found = loop {
            match receive.recv_timeout(Duration::from_millis(100)) {
                Ok(Ok((mutant, fate))) => report.add(mutant, fate),
                Ok(Err(error)) => break Err(error),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break Ok(()),
            }
            if !(request.watch)(report.step()) {
                stop.store(true, Ordering::Relaxed);
            }
        };
        stop.store(true, Ordering::Relaxed);
        found
    })?;
    Ok(report)
}

/// The mutant as a module and as a datapath.
fn trial<'s>(mutant: &Mutant<'s>) -> Result<Trial<'s>, Error> {
    let subject = mutant.subject;
    let module = Arc::new(mutant.fault.apply(&subject.module)?);
    let top = replace(&subject.datapath.top, &module)?;
    Ok(Trial { subject, module, top })
}

#[cfg(test)]
mod tests;
