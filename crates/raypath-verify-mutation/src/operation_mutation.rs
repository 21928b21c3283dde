//! Mutation of operations: whether oracles find a fault in an operation's own dataflow.
//!
//! Netlist and models follow from one function, so that they agree about a fault in it. Here each fault is put into the
//! dataflow that the function describes, before anything follows from it, and must be refused by an oracle that does
//! not come from the function: the exact one of this crate.

mod evaluate;
mod faults;
mod graph;
mod jobs;
mod question;
mod replay;
mod report;
mod staging;
mod subjects;
#[cfg(test)]
mod tests;

use graph::Id;
use question::{Known, Scope, Solver};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use raypath_model::WordModel;
use raypath_tools::pool;
use raypath_verify::{Error, Progress, Request, Verdict};
use raypath_verify_datapath::oracle::Oracle;
use raypath_verify_datapath::subjects::Subject as Tested;
use report::{Fate, Report};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use subjects::Subject;

/// The file with the fate of each fault.
const LIST: &str = "build/verify/operation-mutants.txt";

/// Runs faults of all operations: a sample at level regression, otherwise all.
///
/// # Errors
/// Z3 is missing, or a file cannot be written.
pub fn run(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let jobs = request.jobs.unwrap_or(JOBS) as usize;
    let oracle = |tested: &Tested, model: &WordModel| Oracle::new(tested.config.semantics, model);
    let subjects = subjects::all(request, jobs, &oracle)?;
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

/// Jobs of each operation.
const JOBS: u64 = 8192;

/// Faults at level regression.
const SAMPLE: usize = 1000;

/// The questions of one run of Z3.
const QUESTIONS: usize = 8;

/// The fates of the shard's part of a sample of the faults, on all cores.
fn check_all<'s>(
    subjects: &'s [Subject],
    sample: usize,
    request: &mut Request<'_>,
    solver: &Solver,
) -> Result<Report<'s>, Error> {
    let all = subjects.iter().flat_map(|subject| (0..subject.faults.len()).map(move |fault| (subject, fault)));
    let mut chosen: Vec<(usize, Chosen<'_>)> = all.enumerate().collect();
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
        let mut fates: BTreeMap<usize, Fate> = finished.workers.concat().into_iter().collect();
        let by_id: BTreeMap<usize, Chosen<'_>> = chosen.iter().copied().collect();
        is_stopped = finished.is_stopped || !prove(&mut fates, &by_id, solver, request.proceed)?;
        Ok::<_, Error>(fates)
    })?;
    Ok(Report::new(subjects, shards.into_iter().flatten().collect(), is_stopped))
}

/// A subject and the position of a fault.
type Chosen<'s> = (&'s Subject, usize);

/// Tries to prove that survivors are equivalent. Returns whether the work came to its end.
fn prove(
    fates: &mut BTreeMap<usize, Fate>,
    by_id: &BTreeMap<usize, Chosen<'_>>,
    solver: &Solver,
    proceed: &mut dyn FnMut(Progress) -> bool,
) -> Result<bool, Error> {
    let survivors = |fates: &BTreeMap<usize, Fate>| -> Vec<usize> {
        fates.iter().filter(|(_, fate)| **fate == Fate::Survived).map(|(id, _)| *id).collect()
    };
    let with_survivors: BTreeMap<&str, &Subject> =
        survivors(fates).iter().map(|id| (by_id[id].0.name.as_str(), by_id[id].0)).collect();
    let with_survivors: Vec<&Subject> = with_survivors.into_values().collect();
    let lemmas = pool::map::<_, _, Error>(&with_survivors, pool::ALL_CORES, proceed, |subject, stop| {
        let candidates = subject.values.never_nan(&subject.graph);
        Ok(Some((subject.name.as_str(), solver.lemmas(&subject.graph, candidates, stop)?)))
    })?;
    let lemmas: BTreeMap<&str, BTreeSet<Id>> = lemmas.into_iter().flatten().collect();
    let mut is_whole = true;
    for scope in Scope::ALL {
        let question = |id: usize| {
            let (subject, fault) = by_id[&id];
            let faulty = subject.faults[fault].apply(&subject.graph);
            let known = Known { graph: &subject.graph, lemmas: lemmas.get(subject.name.as_str())? };
            Some((id, question::question(known, &faulty, scope)?))
        };
        let questions: Vec<(usize, String)> = survivors(fates).into_iter().filter_map(question).collect();
        let chunks: Vec<&[(usize, String)]> = questions.chunks(QUESTIONS).collect();
        let proved = pool::map::<_, _, Error>(&chunks, pool::ALL_CORES, proceed, |chunk, stop| {
            solver.prove(chunk.iter().map(|(_, text)| text.clone()).collect(), stop)
        })?;
        is_whole &= proved.iter().all(Option::is_some);
        for (chunk, proved) in chunks.iter().zip(proved) {
            let proved = chunk.iter().zip(proved.into_iter().flatten()).filter(|(_, proved)| *proved);
            fates.extend(proved.map(|((id, _), _)| (*id, Fate::Equivalent)));
        }
    }
    Ok(is_whole)
}

impl Subject {
    /// Runs a fault's jobs, until an outcome is wrong.
    fn fate(&self, fault: usize) -> Fate {
        let faulty = self.faults[fault].apply(&self.graph);
        if self.values.differ(&self.graph, &faulty, &self.jobs) { Fate::Killed } else { Fate::Survived }
    }
}
