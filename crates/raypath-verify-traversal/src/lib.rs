//! The traversal unit: proofs of the control of its modules, a campaign of the whole unit, checks of single modules,
//! and faults in modules.
//!
//! `docs/development/verification.md` has the argument from the proofs to the whole: no ray is lost, duplicated or
//! mixed up, and each that is accepted ends.

mod bindings;
pub mod campaign;
mod claims;
mod modules;
pub mod mutants;
pub mod proofs;
mod setting;
mod system;

use campaign::Counts;
use mutants::{Fate, Mutant, MutatedModule};
use proofs::Obligation;
use raypath_hdl::verilog;
use raypath_rtl::Config;
use raypath_traversal::{NetlistEngine, UnitError, UnitNetlist, UnitParameters};
use raypath_verify::safety::{CheckResult, ModelChecker};
use raypath_verify::{Error, Item, Request, Verdict};
use raypath_work::pool::{self, Cases};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::atomic::AtomicBool;

/// The claims about the traversal unit.
pub const ITEMS: &[Item] = &[Item {
    name: "unit",
    claim: "no module of the traversal unit's control loses, repeats or mixes up a ray, in units of 8, 11, 64 (the \
            default) and 256 contexts; at level full, lists of searches are sorted and lose only what is behind them, and \
            no vector is skipped that was not compared; the netlist returns what the functional model does in random \
            episodes",
    oracle: "proofs by Yosys and ABC of the emitted SystemVerilog of each module, with properties of queues; the \
            functional model, which shares the functions of a step with the netlist, but neither units nor control",
    has_configuration: false,
    run: verify,
}];

const FAILURES_SHOWN: usize = 8;

/// Proves the control of the unit's modules, runs the campaign and the checks of modules, and looks for faults by them.
///
/// # Errors
/// A program is missing or fails; a unit cannot be built.
pub fn verify(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let mut verdict = Verdict::default();
    let proofs = prove(request, &mut verdict)?;
    let counts = run_campaign(request, &mut verdict)?;
    let modules = check_modules(request, &mut verdict)?;
    let faults = check_mutants(request, &mut verdict)?;
    let Counts { episodes, cycles, rays, searches, errors, lost, resets } = counts;
    verdict.covered = format!(
        "{proofs}; {rays} rays and {searches} searches in {episodes} episodes and {cycles} netlist cycles, {errors} with an error of the \
         memory, {lost} ended by {resets} resets; {modules}; {faults}"
    );
    verdict.failures.truncate(FAILURES_SHOWN);
    Ok(verdict)
}

/// Runs the shard's part of `total` cases on all cores, and returns their results in any order. `worker` prepares what
/// runs the cases of a thread. Cases that were not reached when the run was stopped are missing.
fn run_all<T, W>(
    request: &mut Request<'_>,
    verdict: &mut Verdict,
    total: usize,
    worker: impl Fn() -> Result<W, Error> + Sync,
) -> Result<Vec<T>, Error>
where
    T: Send + Serialize + DeserializeOwned,
    W: FnMut(usize, &AtomicBool) -> Result<Option<T>, Error>,
{
    let cases: Cases = request.cases(total as u64, 1);
    let shards = request.parts.phase(|| {
        let finished = pool::run::<_, Error>(cases, pool::ALL_CORES, request.proceed, |queue| {
            let (mut run, mut results) = (worker()?, Vec::new());
            queue.run(|number, stop| {
                results.extend(run(number as usize, stop)?);
                Ok(())
            });
            Ok(results)
        })?;
        Ok::<Vec<T>, Error>(finished.workers.into_iter().flatten().collect())
    })?;
    let results: Vec<T> = shards.into_iter().flatten().collect();
    verdict.is_stopped |= (results.len() as u64) < cases.share();
    Ok(results)
}

/// Checks the obligations, and says how many are proved and refuted.
fn prove(request: &mut Request<'_>, verdict: &mut Verdict) -> Result<String, Error> {
    let obligations: Vec<Obligation> = proofs::obligations(request.level)?;
    let checker = ModelChecker::find()?;
    let results: Vec<(bool, Option<String>)> = run_all(request, verdict, obligations.len(), || {
        Ok(|number: usize, stop: &AtomicBool| {
            let Obligation { problem, expected } = &obligations[number];
            let Some(found) = checker.check(problem, stop)? else { return Ok(None) };
            let failure = (found != *expected).then(|| format!("{}: {found:?}, expected {expected:?}", problem.name));
            Ok(Some((*expected == CheckResult::Holds, failure)))
        })
    })?;
    let count =
        |wanted: bool| results.iter().filter(|(is_proof, failure)| *is_proof == wanted && failure.is_none()).count();
    let (proved, refuted) = (count(true), count(false));
    verdict.failures.extend(results.into_iter().filter_map(|(_, failure)| failure));
    Ok(format!("the control of {proved} modules proved, {refuted} faults and negations refuted"))
}

/// Runs the episodes of the level on all units of the campaign in turn.
fn run_campaign(request: &mut Request<'_>, verdict: &mut Verdict) -> Result<Counts, Error> {
    let total = request.jobs.unwrap_or(request.level.pick(60, 1_500, 60_000));
    let (seed, units) = (request.seed, campaign::units()?);
    let results: Vec<Result<Counts, String>> = run_all(request, verdict, total as usize, || {
        let mut engines = units.iter().map(NetlistEngine::new).collect::<Result<Vec<_>, _>>()?;
        let units = &units;
        Ok(move |number: usize, _: &AtomicBool| {
            let place = number % units.len();
            let unit = &units[place];
            let found = campaign::run(&mut engines[place], unit, [seed, number as u64], false);
            let parameters = unit.parameters;
            Ok(Some(found.map_err(|problem| format!("episode {number} of seed {seed}, {parameters:?}: {problem}"))))
        })
    })?;
    let mut counts = Counts::default();
    for result in results {
        match result {
            Ok(own) => counts.add(&own),
            Err(failure) => verdict.failures.push(failure),
        }
    }
    Ok(counts)
}

/// Runs the checks of the modules that get faults, and of those of the campaign's units.
fn check_modules(request: &mut Request<'_>, verdict: &mut Verdict) -> Result<String, Error> {
    let mut subjects: Vec<_> = mutants::modules()?.into_iter().map(MutatedModule::original).collect();
    for unit in campaign::units()? {
        subjects.extend(verilog::modules(&unit.top)?.into_iter().map(|module| (module, unit.parameters)));
    }
    subjects.retain(|(module, _)| modules::has_check(module));
    let seed = request.seed;
    let results: Vec<Result<(), String>> = run_all(request, verdict, subjects.len(), || {
        Ok(|number: usize, _: &AtomicBool| {
            let (module, parameters) = &subjects[number];
            Ok(Some(modules::check(module, *parameters, seed)?))
        })
    })?;
    let count = results.len();
    verdict.failures.extend(results.into_iter().filter_map(Result::err));
    Ok(format!("{count} modules checked by themselves"))
}

/// The faults without equivalents of which one may survive.
const A_SURVIVOR_IN: usize = 100;

/// Puts faults into the unit's modules, and looks for each by the check of its module, episodes and proofs.
fn check_mutants(request: &mut Request<'_>, verdict: &mut Verdict) -> Result<String, Error> {
    let count = request.level.pick(16, 400, 4_000);
    let subjects = mutants::modules()?;
    let mutants: Vec<Mutant<'_>> = mutants::choose(&subjects, count, request.seed);
    let seed = request.seed;
    let fates: Vec<(String, Fate)> = run_all(request, verdict, mutants.len(), || {
        Ok(|number: usize, stop: &AtomicBool| {
            let mutant = &mutants[number];
            Ok(Some((mutant.description(), mutant.fate(seed, stop)?)))
        })
    })?;
    let (mut checked, mut killed, mut refuted, mut equivalent, mut survivors) = (0_usize, 0, 0, 0, Vec::new());
    for (fault, fate) in fates {
        match fate {
            Fate::Checked => checked += 1,
            Fate::Killed => killed += 1,
            Fate::Refuted => refuted += 1,
            Fate::Equivalent | Fate::Harmless => equivalent += 1,
            Fate::Survived(why) => survivors.push(format!("survivor: {fault}; {why}")),
        }
    }
    let all: usize = subjects.iter().map(|subject| subject.faults.len()).sum();
    let left = survivors.len();
    verdict.remarks.extend(survivors);
    let found = checked + killed + refuted;
    // The score is that of the whole sample: a few faults of a shard may have a low one.
    let (of, most) = (found + left, (found + left).div_ceil(A_SURVIVOR_IN));
    if left > most && !request.parts.is_saved() {
        verdict.failures.push(format!("{left} of {of} faults survive, expected at most {most}"));
    }
    Ok(format!(
        "of the {all} faults in {} modules, {checked} found by checks of their modules, {killed} by the campaign, \
         {refuted} by the proofs, {equivalent} proven equivalent, {left} survivors",
        subjects.len()
    ))
}

/// Builds a traversal unit.
fn built(config: Config, parameters: UnitParameters) -> Result<UnitNetlist, Error> {
    UnitNetlist::new(config, parameters).map_err(|problem| match problem {
        UnitError::Netlist(problem) => Error::Netlist(problem),
        other => Error::subject(other),
    })
}
