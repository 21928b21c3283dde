//! Mutation testing: whether the regression tests find a fault in the netlist.

mod logic;
mod mutant;
mod report;
mod symbolic;
mod trial;
mod units;

use mutant::{Mutant, MutantResult, Subject, choose, subjects};
use raypath_hdl::mutate::replace;
pub use raypath_sim::lockstep::CONFIGS;
use raypath_tools::{ToolError, pool};
use raypath_verify::{Error, Level, Request, Verdict};
use report::Report;
use std::path::Path;
use std::sync::Arc;
use trial::Trial;

/// The file with the result of each mutant.
const LIST: &str = "build/verify/mutants.txt";

/// Runs the checks of the regression tests on a sample of the faults of all modules.
pub fn run(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let count = request.jobs.unwrap_or(request.level.pick(120, 2400, 10_000)) as usize;
    let subjects = subjects(&CONFIGS)?;
    let mutants = choose(&subjects, count, request.seed);
    let proves_modules = request.level > Level::Regression;
    let report = check_all(&subjects, &mutants, request, &|trial| trial.run(proves_modules))?;
    report.write(Path::new(LIST))?;
    let mut verdict = report.verdict();
    if request.parts.is_saved() {
        // The score is that of the whole sample: a few mutants of a shard may have a low one.
        verdict.failures.clear();
    }
    Ok(verdict)
}

type Check<'a> = &'a (dyn Fn(&Trial<'_>) -> Result<MutantResult, Error> + Sync);

/// Runs `check` on each mutant of the shard, on all cores.
fn check_all<'s>(
    subjects: &'s [Subject],
    mutants: &[Mutant<'s>],
    request: &mut Request<'_>,
    check: Check<'_>,
) -> Result<Report<'s>, Error> {
    let cases = request.cases(mutants.len() as u64, 1);
    let shards = request.parts.phase(|| {
        let finished = pool::run::<_, Error>(cases, pool::ALL_CORES, request.proceed, |queue| {
            let mut results = Vec::new();
            queue.run(|number, _| {
                results.push((number, check(&trial(&mutants[number as usize])?)?));
                Ok(())
            });
            Ok(results)
        })?;
        Ok::<_, Error>(finished.workers.concat())
    })?;
    let mut report = Report::new(subjects, cases.share() as usize);
    for (number, result) in shards.into_iter().flatten() {
        let mutant = mutants.get(number as usize);
        let mutant = mutant.ok_or_else(|| ToolError::unexpected("a part", format!("mutant {number}"), "a mutant"))?;
        report.add(mutant, result);
    }
    Ok(report)
}

/// Builds a mutant's module and datapath.
fn trial<'s>(mutant: &Mutant<'s>) -> Result<Trial<'s>, Error> {
    let subject = mutant.subject;
    let module = Arc::new(mutant.fault.apply(&subject.module)?);
    let top = replace(&subject.datapath.top, &module)?;
    Ok(Trial { subject, module, top })
}

#[cfg(test)]
mod tests;
