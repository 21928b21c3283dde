//! Mutation of operations: whether oracles find a fault in an operation's own dataflow.
//!
//! Netlist and models follow from one function, so that they agree about a fault in it. Here each fault is put into the
//! dataflow that the function describes, before anything follows from it, and must be refused by an oracle that does
//! not come from the function: golden vectors, the text of the semantics, or exact arithmetic.

mod evaluate;
mod expected;
mod faults;
mod graph;
mod question;
mod replay;
mod report;
mod staging;
mod subjects;
#[cfg(test)]
mod tests;

use crate::{Error, Request, Verdict};
use question::{Known, Scope, Solver};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use raypath_tools::pool;
use report::{Fate, Report};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use subjects::Subject;

/// The file with the fate of each fault.
const LIST: &str = "build/verify/operation-mutants.txt";

/// Runs faults of all operations: a sample at level regression, otherwise all.
///
/// # Errors
/// Golden vectors or Z3 are missing, or a file cannot be written.
pub(crate) fn run(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let jobs = request.jobs.unwrap_or(request.level.pick(2048, 16_384, 65_536)) as usize;
    let subjects = subjects::all(request.level, jobs, request.seed)?;
    let sample = request.level.pick(SAMPLE, usize::MAX, usize::MAX);
    let mut report = check_all(&subjects, sample, request, &Solver::find()?)?;
    report.staging = staging::check(request)?;
    report.write(Path::new(LIST))?;
    let mut verdict = report.verdict();
    if request.parts.is_saved() {
        // The score is that of all shards together.
        verdict.failures.clear();
    }
    Ok(verdict)
}

/// Faults at level regression. The proofs of those that no oracle refuses take most of the time.
const SAMPLE: usize = 1000;

/// The most outcomes of a fault that an oracle judges: exact arithmetic is slow.
const JUDGED: usize = 2000;

/// The questions of one run of Z3.
const QUESTIONS: usize = 16;

/// The fates of the shard's part of a sample of the faults, on all cores.
fn check_all<'s>(
    subjects: &'s [Subject],
    sample: usize,
    request: &mut Request<'_>,
    solver: &Solver,
) -> Result<Report<'s>, Error> {
    let all = subjects.iter().flat_map(|subject| (0..subject.faults.len()).map(move |fault| (subject, fault)));
    let mut chosen: Vec<(usize, (&Subject, usize))> = all.enumerate().collect();
    if sample < chosen.len() {
        chosen.shuffle(&mut ChaCha8Rng::seed_from_u64(request.seed));
        chosen.truncate(sample);
    }
    let cases = request.cases(chosen.len() as u64, 1);
    let mut is_stopped = false;
    let shards = request.parts.phase(|| {
        let finished = pool::run::<_, Error>(cases, pool::ALL_CORES, request.proceed, |queue| {
            let mut fates = Vec::new();
            queue.run(|number, _| {
                let (id, (subject, fault)) = chosen[number as usize];
                fates.push((id, subject.fate(fault)));
                Ok(())
            });
            Ok(fates)
        })?;
        is_stopped = finished.is_stopped;
        let mut fates: BTreeMap<usize, Fate> = finished.workers.concat().into_iter().collect();
        let by_id: BTreeMap<usize, (&Subject, usize)> = chosen.iter().copied().collect();
        let never = |subject: &&Subject, stop: &AtomicBool| {
            let candidates = subject.values.never_nan(&subject.graph);
            let lemmas = solver.lemmas(&subject.graph, candidates, stop)?;
            Ok(Some((subject.name.clone(), lemmas)))
        };
        let of: Vec<&Subject> = subjects.iter().collect();
        let lemmas = pool::map::<_, _, Error>(&of, pool::ALL_CORES, request.proceed, never)?;
        let lemmas: BTreeMap<String, BTreeSet<graph::Id>> = lemmas.into_iter().flatten().collect();
        for scope in Scope::ALL {
            let question = |id: usize| {
                let (subject, fault) = by_id[&id];
                let faulty = subject.faults[fault].apply(&subject.graph);
                let known = Known {
                    graph: &subject.graph,
                    assumptions: &subject.assumptions,
                    lemmas: lemmas.get(&subject.name)?,
                };
                Some((id, question::question(known, &faulty, scope)?))
            };
            let unseen = fates.iter().filter(|(_, fate)| **fate == Fate::Survived { differs: false });
            let questions: Vec<(usize, String)> = unseen.filter_map(|(id, _)| question(*id)).collect();
            let chunks: Vec<&[(usize, String)]> = questions.chunks(QUESTIONS).collect();
            let proved = pool::map::<_, _, Error>(&chunks, pool::ALL_CORES, request.proceed, |chunk, stop| {
                solver.prove(chunk.iter().map(|(_, text)| text.clone()).collect(), stop)
            })?;
            is_stopped |= proved.iter().any(Option::is_none);
            for (chunk, proved) in chunks.iter().zip(proved) {
                let proved = chunk.iter().zip(proved.into_iter().flatten()).filter(|(_, proved)| *proved);
                fates.extend(proved.map(|((id, _), _)| (*id, Fate::Equivalent)));
            }
        }
        Ok::<_, Error>(fates)
    })?;
    Ok(Report::new(subjects, shards.into_iter().flatten().collect(), is_stopped))
}

impl Subject {
    /// Runs a fault's jobs, until an outcome is refused.
    fn fate(&self, fault: usize) -> Fate {
        let faulty = self.faults[fault].apply(&self.graph);
        let mut judged = 0;
        let is_refused = self.values.differences(&self.graph, &faulty, &self.jobs, |step, job, outcome| {
            judged += 1;
            judged <= JUDGED && self.refuses(step, job, &outcome)
        });
        if is_refused { Fate::Killed } else { Fate::Survived { differs: judged > 0 } }
    }
}
