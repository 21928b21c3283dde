//! Mutation of operations: whether oracles find a fault in an operation's own dataflow.
//!
//! Netlist and models follow from one function, so that they agree about a fault in it. Here each fault is put into the
//! dataflow that the function describes, before anything follows from it, and must be refused by an oracle that does
//! not come from the function: the exact one of the campaigns.

mod evaluate;
mod faults;
mod jobs;
mod question;
mod subjects;
#[cfg(test)]
mod tests;

use crate::report::{Fate, Judged, Report};
use question::Known;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use raypath_tools::{SmtSolver, ToolError};
use raypath_verify::{Error, Request, Verdict};
use raypath_work::pool;
use std::sync::atomic::AtomicBool;
use subjects::{FaultyOperation, Planned, exact, plan};

/// The file with the fate of each fault.
const LIST: &str = "build/verify/operation-mutants.txt";

/// The questions of one run of Z3.
const QUESTIONS: usize = 8;

/// Runs a sample of the faults of all operations. A shard has some of the operations.
///
/// # Errors
/// Z3 is missing, or a file cannot be written.
pub fn run(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let (planned, shard, seed) = (plan(), request.shard, request.seed);
    let jobs = request.jobs.unwrap_or(request.level.pick(1024, 8192, 8192)) as usize;
    let population: usize = planned.iter().map(|planned| planned.faults.len()).sum();
    let sample = request.level.pick(600, 6000, population);
    let own: Vec<&Planned> = (0..).zip(&planned).filter(|(number, _)| shard.takes(*number)).map(|it| it.1).collect();
    let mut is_stopped = false;
    let shards = request.parts.phase(|| {
        let z3 = SmtSolver::z3()?;
        let judged = pool::map::<_, _, Error>(&own, pool::ALL_CORES, request.proceed, |planned, stop| {
            let subject = planned.subject(jobs, seed, &exact);
            let mut chosen: Vec<usize> = (0..planned.faults.len()).collect();
            chosen.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
            chosen.truncate((chosen.len() * sample).div_ceil(population));
            let judged = judged(&subject, &chosen, &z3, stop)?;
            Ok(judged.map(|judged| (judged, subject.refused)))
        })?;
        is_stopped = judged.iter().any(Option::is_none);
        Ok::<Vec<(Vec<Judged>, Option<String>)>, Error>(judged.into_iter().flatten().collect())
    })?;
    let (judged, refused): (Vec<_>, Vec<_>) = shards.into_iter().flatten().unzip();
    let population = (population, format!("{} operations", planned.len()));
    let mut verdict = Report { judged: judged.concat(), population, is_stopped }.verdict(request, LIST)?;
    verdict.failures.extend(refused.into_iter().flatten());
    Ok(verdict)
}

/// The fates of faults, by number; none if `stop` is set meanwhile.
fn judged(
    subject: &FaultyOperation<'_>,
    chosen: &[usize],
    z3: &SmtSolver,
    stop: &AtomicBool,
) -> Result<Option<Vec<Judged>>, Error> {
    let mut judged: Vec<Judged> = chosen.iter().map(|&fault| subject.judged(fault)).collect();
    match prove(subject, chosen, &mut judged, z3, stop) {
        Err(ToolError::Stopped) => Ok(None),
        other => Ok(other.map(|()| Some(judged))?),
    }
}

/// Tries to prove that survivors are equivalent.
fn prove(
    subject: &FaultyOperation<'_>,
    chosen: &[usize],
    judged: &mut [Judged],
    z3: &SmtSolver,
    stop: &AtomicBool,
) -> Result<(), ToolError> {
    let flow = &subject.planned.flow;
    let mut known = None;
    for (is_near, how) in [(true, "near the fault"), (false, "by the laws of units")] {
        let is_survivor = |place: &usize| matches!(judged[*place].fate, Fate::Survived(_));
        let survivors: Vec<usize> = (0..judged.len()).filter(is_survivor).collect();
        for places in survivors.chunks(QUESTIONS) {
            let known = match &mut known {
                Some(known) => known,
                none => none.insert(Known::new(z3, flow, subject.values.never_nan(flow), stop)?),
            };
            let faulty = |place: &usize| subject.planned.faults[chosen[*place]].apply(flow);
            let questions: Vec<String> = places.iter().map(|place| known.question(&faulty(place), is_near)).collect();
            let answers = question::answers(z3, &questions, stop)?;
            for (&place, _) in places.iter().zip(answers).filter(|(_, is_proved)| *is_proved) {
                judged[place].fate = Fate::Equivalent(how.to_string());
            }
        }
    }
    Ok(())
}

impl FaultyOperation<'_> {
    /// Runs a fault's jobs, until an outcome is wrong.
    fn judged(&self, fault: usize) -> Judged {
        let Planned { flow, faults, .. } = self.planned;
        let fate = match self.values.differ(flow, &faults[fault].apply(flow), &self.jobs) {
            true => Fate::Killed("the exact oracle".to_string()),
            false => Fate::Survived("not proven".to_string()),
        };
        Judged { subject: self.name.clone(), fault: faults[fault].text.clone(), fate }
    }
}
