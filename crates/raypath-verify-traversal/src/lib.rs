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

use campaign::{Counts, Subject};
use mutants::{Fate, Mutant};
use proofs::{Checked, Obligation};
use raypath_hdl::verilog;
use raypath_rtl::Config;
use raypath_tools::pool;
use raypath_traversal::{NetlistEngine, UnitError, UnitNetlist, UnitParameters};
use raypath_verify::{Error, Item, Request, Verdict};
use serde::{Deserialize, Serialize};

/// The claims about the traversal unit.
pub const ITEMS: &[Item] = &[Item {
    name: "unit",
    claim: "the traversal unit loses, repeats and mixes up no ray, and its netlist returns what the functional \
            model does, for any memory, any users of the channels and resets",
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
    let Counts { episodes, cycles, rays, errors, lost, resets } = counts;
    verdict.covered = format!(
        "{proofs}; {rays} rays in {episodes} episodes and {cycles} netlist cycles, {errors} with an error of the \
         memory, {lost} ended by {resets} resets; {modules}; {faults}"
    );
    verdict.failures.truncate(FAILURES_SHOWN);
    Ok(verdict)
}

/// Checks the obligations, and says how many are proved and refuted.
fn prove(request: &mut Request<'_>, verdict: &mut Verdict) -> Result<String, Error> {
    let (level, shard) = (request.level, request.shard);
    let results: Vec<Vec<Option<Checked>>> = request.parts.phase(|| {
        let obligations: Vec<Obligation> = proofs::obligations(level)?;
        proofs::check(&obligations, shard, request.proceed)
    })?;
    let (mut proved, mut refuted) = (0, 0);
    for result in results.into_iter().flatten() {
        match result {
            None => verdict.is_stopped = true,
            Some((_, Some(failure))) => verdict.failures.push(failure),
            Some((true, None)) => proved += 1,
            Some((false, None)) => refuted += 1,
        }
    }
    Ok(format!("the control of {proved} modules proved, {refuted} faults and negations refuted"))
}

/// The episodes of a worker.
#[derive(Default, Serialize, Deserialize)]
struct Episodes {
    counts: Counts,
    failures: Vec<String>,
}

/// Runs the episodes of the level on all units of the campaign in turn.
fn run_campaign(request: &mut Request<'_>, verdict: &mut Verdict) -> Result<Counts, Error> {
    let total = request.jobs.unwrap_or(request.level.pick(60, 8_000, 60_000));
    let (seed, cases) = (request.seed, request.cases(total, 1));
    let subjects = Subject::all()?;
    let shards = request.parts.phase(|| {
        let finished = pool::run::<_, Error>(cases, pool::ALL_CORES, request.proceed, |queue| {
            let mut engines: Vec<NetlistEngine> = Vec::new();
            for subject in &subjects {
                engines.push(NetlistEngine::new(&subject.unit)?);
            }
            let mut found = Episodes::default();
            queue.run(|number, _| {
                let place = number as usize % subjects.len();
                match campaign::run(&mut engines[place], &subjects[place].unit, [seed, number], None) {
                    Ok(counts) => found.counts.add(&counts),
                    Err(problem) => {
                        let parameters = subjects[place].unit.parameters;
                        found.failures.push(format!("episode {number} of seed {seed}, {parameters:?}: {problem}"));
                    }
                }
                Ok(())
            });
            Ok(found)
        })?;
        Ok::<_, Error>(finished.workers)
    })?;
    let mut counts = Counts::default();
    for Episodes { counts: own, failures } in shards.into_iter().flatten() {
        counts.add(&own);
        verdict.failures.extend(failures);
    }
    verdict.is_stopped |= counts.episodes + (verdict.failures.len() as u64) < cases.share();
    Ok(counts)
}

/// Runs the checks of the modules that get faults, and at further levels of those of the campaign's units.
fn check_modules(request: &mut Request<'_>, verdict: &mut Verdict) -> Result<String, Error> {
    let mut subjects: Vec<_> = mutants::subjects()?.into_iter().map(mutants::Subject::original).collect();
    for Subject { unit } in Subject::all()?.into_iter().take(request.level.pick(0, usize::MAX, usize::MAX)) {
        subjects.extend(verilog::modules(&unit.top)?.into_iter().map(|module| (module, unit.parameters)));
    }
    subjects.retain(|(module, _)| modules::has_check(module));
    let (cases, seed) = (request.cases(subjects.len() as u64, 1), request.seed);
    let shards = request.parts.phase(|| {
        let finished = pool::run::<_, Error>(cases, pool::ALL_CORES, request.proceed, |queue| {
            let mut results: Vec<Result<(), String>> = Vec::new();
            queue.run(|number, _| {
                let (module, parameters) = &subjects[number as usize];
                results.push(modules::check(module, *parameters, seed)?);
                Ok(())
            });
            Ok(results)
        })?;
        Ok::<_, Error>(finished.workers.concat())
    })?;
    let results: Vec<Result<(), String>> = shards.into_iter().flatten().collect();
    let count = results.len();
    verdict.is_stopped |= (count as u64) < cases.share();
    verdict.failures.extend(results.into_iter().filter_map(Result::err));
    Ok(format!("{count} modules checked by themselves"))
}

/// The share of the faults without equivalents that must be found, in hundredths.
const LEAST_SCORE: usize = 99;

/// Puts faults into the unit's modules, and looks for each by the check of its module, episodes and proofs.
fn check_mutants(request: &mut Request<'_>, verdict: &mut Verdict) -> Result<String, Error> {
    let count = request.level.pick(16, 400, 4_000);
    let subjects = mutants::subjects()?;
    let mutants: Vec<Mutant<'_>> = mutants::choose(&subjects, count, request.seed);
    let (cases, seed) = (request.cases(mutants.len() as u64, 1), request.seed);
    let limits = mutants::limits(seed)?;
    let shards = request.parts.phase(|| {
        let finished = pool::run::<_, Error>(cases, pool::ALL_CORES, request.proceed, |queue| {
            let mut fates: Vec<(String, Fate)> = Vec::new();
            queue.run(|number, stop| {
                let mutant = &mutants[number as usize];
                fates.push((mutant.fault.to_string(), mutant.fate(seed, &limits, stop)?));
                Ok(())
            });
            Ok(fates)
        })?;
        Ok::<_, Error>(finished.workers.concat())
    })?;
    let (mut checked, mut killed, mut refuted, mut equivalent, mut survivors) = (0_usize, 0, 0, 0, Vec::new());
    for (fault, fate) in shards.into_iter().flatten() {
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
    if 100 * found < LEAST_SCORE * (found + left) && !request.parts.is_saved() {
        let of = found + left;
        verdict.failures.push(format!("{found} of {of} faults are found, expected at least {LEAST_SCORE} %"));
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
