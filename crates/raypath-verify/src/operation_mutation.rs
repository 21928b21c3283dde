//! Mutation of operations: whether oracles find a fault in an operation's own dataflow.
//!
//! Netlist and models follow from one function, so that they agree about a fault in it. Here each fault is put into the
//! dataflow that the function describes, before anything follows from it, and must be refused by an oracle that does not
//! come from the function: golden vectors, the text of the semantics, or exact arithmetic.

mod evaluate;
mod expected;
mod faults;
mod graph;
mod question;
mod replay;
mod report;
mod subjects;
#[cfg(test)]
mod tests;

use crate::{Error, Level, Request, Verdict};
use question::Solver;
use raypath_tools::pool;
use report::{Fate, Report};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use subjects::Subject;

/// The file with the fate of each fault.
const LIST: &str = "build/verify/operation-mutants.txt";

/// Runs all faults of all operations.
///
/// # Errors
/// Golden vectors or Z3 are missing, or a file cannot be written.
pub(crate) fn run(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let jobs = request.jobs.unwrap_or(request.level.pick(2048, 16_384, 65_536)) as usize;
    let subjects = subjects::all(request.level, jobs, request.seed)?;
    // The proofs take most of the time.
    let solver = if request.level > Level::Regression { Some(Solver::find()?) } else { None };
    let report = check_all(&subjects, request, &|subject, fault, stop| subject.fate(fault, solver.as_ref(), stop))?;
    report.write(Path::new(LIST))?;
    Ok(report.verdict())
}

type Check<'a> = &'a (dyn Fn(&Subject, usize, &AtomicBool) -> Result<Fate, Error> + Sync);

/// The fates of the shard's faults, on all cores.
fn check_all<'s>(subjects: &'s [Subject], request: &mut Request<'_>, check: Check<'_>) -> Result<Report<'s>, Error> {
    let faults =
        subjects.iter().enumerate().flat_map(|(at, subject)| (0..subject.faults.len()).map(move |fault| (at, fault)));
    let faults: Vec<(usize, usize)> = faults.collect();
    let cases = request.cases(faults.len() as u64, 1);
    let shards = request.parts.phase(|| {
        let finished = pool::run::<_, Error>(cases, pool::ALL_CORES, request.proceed, |queue| {
            let mut fates = Vec::new();
            queue.run(|number, stop| {
                let (subject, fault) = faults[number as usize];
                fates.push((number, check(&subjects[subject], fault, stop)?));
                Ok(())
            });
            Ok(fates)
        })?;
        Ok::<_, Error>(finished.workers.concat())
    })?;
    let fates = shards.into_iter().flatten().map(|(number, fate)| (number as usize, fate)).collect();
    Ok(Report::new(subjects, fates, cases.share() as usize))
}

impl Subject {
    /// Runs a fault's jobs; if no outcome is refused, asks the solver, if there is one.
    fn fate(&self, fault: usize, solver: Option<&Solver>, stop: &AtomicBool) -> Result<Fate, Error> {
        let faulty = self.faults[fault].apply(&self.graph);
        let (mut judged, mut differs) = (0, false);
        let is_refused = self.values.differences(&self.graph, &faulty, &self.jobs, |step, job, outcome| {
            differs = true;
            judged += 1;
            judged <= JUDGED && self.refuses(step, job, &outcome)
        });
        if is_refused {
            return Ok(Fate::Killed);
        }
        match solver {
            Some(solver) if !differs && solver.proves_equal(&self.graph, &faulty, stop)? => Ok(Fate::Equivalent),
            _ => Ok(Fate::Survived { differs }),
        }
    }
}

/// The most outcomes of a fault that an oracle judges: exact arithmetic is slow.
const JUDGED: usize = 2000;
