//! Mutation testing: whether the regression tests find a fault in the netlist.

mod mutant;
mod trial;
mod units;

use crate::report::{Fate, Judged, Report};
use mutant::{FaultyModule, Mutant, choose, subjects};
use raypath_hdl::mutate::replace;
use raypath_rtl::Config;
use raypath_sim::lockstep::CONFIGS;
use raypath_verify::{Error, Level, Request, Verdict};
use raypath_work::pool::{self, Shard};
use std::sync::Arc;
use trial::Trial;

/// The file with the result of each mutant.
const LIST: &str = "build/verify/mutants.txt";

/// Runs the checks of the regression tests on a sample of the faults of all modules. A shard has some of the faults; at
/// level regression it has those of some of the configurations, because each takes time to elaborate.
pub fn run(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let count = request.jobs.unwrap_or(request.level.pick(120, 1600, 10_000)) as usize;
    let all = || (0..).zip(CONFIGS);
    let (configs, shard): (Vec<Config>, Shard) = match request.level {
        Level::Regression => {
            (all().filter(|(number, _)| request.shard.takes(*number)).map(|it| it.1).collect(), Shard::ALL)
        }
        _ => (CONFIGS.to_vec(), request.shard),
    };
    let subjects = subjects(&configs)?;
    let mutants = choose(&subjects, count * configs.len() / CONFIGS.len(), request.seed);
    check_all(&subjects, &mutants, request, shard, &|trial| trial.run())?.verdict(request, LIST)
}

type Check<'a> = &'a (dyn Fn(&Trial<'_>) -> Result<Fate, Error> + Sync);

/// Runs `check` on each mutant of the shard, on all cores.
fn check_all(
    subjects: &[FaultyModule],
    mutants: &[Mutant<'_>],
    request: &mut Request<'_>,
    shard: Shard,
    check: Check<'_>,
) -> Result<Report, Error> {
    let own: Vec<&Mutant<'_>> = (0..).zip(mutants).filter(|(number, _)| shard.takes(*number)).map(|it| it.1).collect();
    let mut is_stopped = false;
    let shards = request.parts.phase(|| {
        let judged = pool::map::<_, _, Error>(&own, pool::ALL_CORES, request.proceed, |mutant, _| {
            let subject = format!("{} ({})", mutant.subject.module.name(), mutant.subject.datapath.config);
            let (fault, fate) = (mutant.fault.to_string(), check(&trial(mutant)?)?);
            Ok(Some(Judged { subject, fault, fate }))
        })?;
        is_stopped = judged.iter().any(Option::is_none);
        Ok::<Vec<Judged>, Error>(judged.into_iter().flatten().collect())
    })?;
    let population = subjects.iter().map(|subject| subject.faults.len()).sum();
    let population = (population, format!("{} modules", subjects.len()));
    Ok(Report { judged: shards.concat(), population, is_stopped })
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
