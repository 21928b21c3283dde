//! binary32 addition, proved for one difference of exponents at a time.

use super::claim::{Claim, Operands, Subject};
use super::judged::{Judged, judge};
use super::kept::Kept;
use crate::proof::{Prover, pool};
use crate::{Error, Level, Request, Step, Verdict};
use raypath_float::Format;
use std::path::Path;
use std::time::{Duration, Instant};

/// Where proofs are kept, from the folder in which the program runs.
pub const ADDER_PROOF_FOLDER: &str = "build/verify/adder-proof";

/// The largest difference of two biased exponents of binary32.
const FARTHEST: i64 = 255;
/// The difference for which the deliberate fault, which is one of rounding, has to be seen.
const FAULT_AT: i64 = 3;

/// Proves binary32 addition for the differences of exponents that the level asks for; at level long, for all 511, which
/// are all pairs of operands. A proof that was done before is not repeated. The work is divided by differences.
///
/// # Errors
/// A program is missing or fails, or the folder cannot be written.
pub fn adder_proof(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let prover = Prover::find()?;
    let kept = Kept::open(Path::new(ADDER_PROOF_FOLDER), prover.versions())?;
    let chosen = differences(request.level);
    let shard = request.shard;
    let cases: Vec<Claim> = chosen
        .iter()
        .zip(0..)
        .filter(|&(_, number)| shard.takes(number))
        .map(|(&difference, _)| Claim {
            subject: Subject::Add,
            format: Format::BINARY32,
            operands: Operands::ExponentDifference(difference),
        })
        .collect();
    let fault =
        Claim { subject: Subject::Add, format: Format::BINARY32, operands: Operands::ExponentDifference(FAULT_AT) };
    // That the proof can fail is shown anew each time.
    let work: Vec<(Claim, bool)> =
        std::iter::once((fault, true)).chain(cases.iter().map(|&claim| (claim, false))).collect();
    let limit = Duration::from_secs(request.level.pick(300, 1800, 7200));
    let total = work.len();
    let watch = |done: usize| (request.watch)(Step { done: done as u64, total: total as u64 });
    let found = pool::for_each(
        &work,
        |&(claim, with_fault), stop| {
            let problem = claim.problem(None)?;
            if !with_fault && kept.has(&problem) {
                return Ok(Some((Judged { claim, result: Ok(()), seen: None }, true)));
            }
            let begin = Instant::now();
            let Some(judged) = judge(&prover, claim, with_fault, limit, stop)? else { return Ok(None) };
            if judged.result.is_ok() {
                kept.keep(&problem, &format!("{claim}: proved in {:.1} s", begin.elapsed().as_secs_f64()))?;
            }
            Ok(Some((judged, false)))
        },
        watch,
    )?;
    let is_stopped = found.iter().any(Option::is_none);
    let (first, rest) = found.split_at(1);
    let proved = rest.iter().flatten().filter(|(judged, _)| judged.result.is_ok()).count();
    let before = rest.iter().flatten().filter(|(_, before)| *before).count();
    let mut remarks = vec![format!("with {}; {before} of these proofs were done before", prover.versions())];
    remarks.extend(
        first
            .iter()
            .flatten()
            .filter_map(|(judged, _)| Some(format!("a deliberate fault is seen: {}", judged.seen.clone()?))),
    );
    if chosen.len() < differences(Level::Long).len() {
        remarks.push(format!("level {} proves {} of 511 differences", request.level.name(), chosen.len()));
    }
    Ok(Verdict {
        covered: format!("binary32 addition, {proved} of 511 differences of exponents proved"),
        failures: found.iter().flatten().filter_map(|(judged, _)| judged.result.clone().err()).collect(),
        remarks,
        is_stopped,
    })
}

/// The differences that are proved, the easiest first.
fn differences(level: Level) -> Vec<i64> {
    let all = (0..=FARTHEST).rev().flat_map(|distance| match distance {
        0 => vec![0],
        _ => vec![-distance, distance],
    });
    match level {
        Level::Everyday => vec![-100],
        Level::Full => all.filter(|difference| difference % 16 == 0).collect(),
        Level::Long => all.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_long_level_leaves_no_difference_out() {
        let mut all = differences(Level::Long);
        all.sort_unstable();
        assert_eq!(all, (-255..=255).collect::<Vec<_>>());
        assert_eq!(differences(Level::Full).len(), 31);
    }
}
