//! Proofs that are too long in one piece: binary32 addition, one difference of exponents at a time, and binary16
//! multiplication, one fraction of the second operand at a time.

use super::claim::{Claim, Operands, Subject};
use super::judged::{Judged, judge};
use super::kept::Kept;
use crate::proof::{Prover, pool};
use crate::{Error, Level, Request, Step, Verdict};
use raypath_float::Format;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// Where proofs are kept, from the folder in which the program runs.
pub const CASES_FOLDER: &str = "build/verify/proofs";

/// Proves binary32 addition for the differences of exponents that the level asks for; at level long for all 511, which
/// are all pairs of operands. A proof that was done before is not repeated. The work is divided by differences.
///
/// # Errors
/// A program is missing or fails, or the folder cannot be written.
pub fn adder_proof(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let case = |difference| Claim {
        subject: Subject::Add,
        format: Format::BINARY32,
        operands: Operands::ExponentDifference(difference),
    };
    let cases = Cases {
        what: "binary32 addition, by difference of exponents",
        chosen: differences(request.level).into_iter().map(case).collect(),
        total: differences(Level::Long).len(),
        // It is wrong in a rounding of a difference, which these have.
        fault: case(3),
    };
    cases.prove(request)
}

/// Proves binary16 multiplication for the fractions of the second operand that the level asks for; at level long for all
/// 1024, which are all pairs of operands. A proof that was done before is not repeated. The work is divided by fractions.
///
/// # Errors
/// A program is missing or fails, or the folder cannot be written.
pub fn multiplier_proof(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let case =
        |fraction| Claim { subject: Subject::Mul, format: Format::BINARY16, operands: Operands::Fraction(fraction) };
    let cases = Cases {
        what: "binary16 multiplication, by fraction of the second operand",
        chosen: fractions(request.level).into_iter().map(case).collect(),
        total: fractions(Level::Long).len(),
        fault: case(0x155),
    };
    cases.prove(request)
}

/// The differences of biased exponents that are proved, the easiest first.
fn differences(level: Level) -> Vec<i64> {
    let all = (0..=255).rev().flat_map(|distance| match distance {
        0 => vec![0],
        _ => vec![-distance, distance],
    });
    match level {
        Level::Everyday => vec![-100],
        Level::Full => all.filter(|difference| difference % 16 == 0).collect(),
        Level::Long => all.collect(),
    }
}

/// The fractions that are proved.
fn fractions(level: Level) -> Vec<u64> {
    match level {
        Level::Everyday => vec![0x2ab],
        // An odd step: every bit is 0 in some and 1 in others.
        Level::Full => (0..1024).step_by(33).collect(),
        Level::Long => (0..1024).collect(),
    }
}

/// A claim in cases, each of which is proved by itself.
struct Cases {
    /// What is claimed, and how it is divided.
    what: &'static str,
    /// The cases that are proved.
    chosen: Vec<Claim>,
    /// How many cases there are.
    total: usize,
    /// The case for which the fault has to be seen.
    fault: Claim,
}

impl Cases {
    fn prove(self, request: &mut Request<'_>) -> Result<Verdict, Error> {
        let prover = Prover::find()?;
        let kept = Kept::open(Path::new(CASES_FOLDER), prover.versions())?;
        let shard = request.shard;
        let mine = self.chosen.iter().zip(0..).filter(|&(_, number)| shard.takes(number)).map(|(claim, _)| *claim);
        // That the proof can fail is shown anew each time.
        let work: Vec<(Claim, bool)> =
            std::iter::once((self.fault, true)).chain(mine.map(|claim| (claim, false))).collect();
        let limit = Duration::from_secs(request.level.pick(300, 1800, 7200));
        let watch = |done: usize| (request.watch)(Step { done: done as u64, total: work.len() as u64 });
        let one = |&(claim, with_fault): &(Claim, bool), stop: &AtomicBool| {
            prove_once(&prover, &kept, claim, with_fault, limit, stop)
        };
        let found = pool::for_each(&work, one, watch)?;
        let (first, rest) = found.split_at(1);
        let proved = rest.iter().flatten().filter(|done| done.judged.result.is_ok()).count();
        let before = rest.iter().flatten().filter(|done| done.is_old).count();
        let mut remarks = vec![format!("with {}; {before} of these proofs were done before", prover.versions())];
        let seen = first.iter().flatten().filter_map(|done| done.judged.seen.as_ref());
        remarks.extend(seen.map(|seen| format!("a deliberate fault is seen: {seen}")));
        if self.chosen.len() < self.total {
            let level = request.level.name();
            remarks.push(format!("level {level} proves {} of {} cases", self.chosen.len(), self.total));
        }
        Ok(Verdict {
            covered: format!("{}, {proved} of {} cases proved", self.what, self.total),
            failures: found.iter().flatten().filter_map(|done| done.judged.result.clone().err()).collect(),
            remarks,
            is_stopped: found.iter().any(Option::is_none),
        })
    }
}

/// A case that is done.
struct Done {
    judged: Judged,
    /// Whether it was done before.
    is_old: bool,
}

/// Proves a case unless that is done; nothing where it was stopped.
fn prove_once(
    prover: &Prover,
    kept: &Kept,
    claim: Claim,
    with_fault: bool,
    limit: Duration,
    stop: &AtomicBool,
) -> Result<Option<Done>, Error> {
    let problem = claim.problem(None)?;
    if !with_fault && kept.has(&problem) {
        return Ok(Some(Done { judged: Judged { claim, result: Ok(()), seen: None }, is_old: true }));
    }
    let begin = Instant::now();
    let Some(judged) = judge(prover, claim, with_fault, limit, stop)? else { return Ok(None) };
    if judged.result.is_ok() {
        kept.keep(&problem, &format!("{claim}: proved in {:.1} s", begin.elapsed().as_secs_f64()))?;
    }
    Ok(Some(Done { judged, is_old: false }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_long_level_leaves_no_case_out() {
        let mut all = differences(Level::Long);
        all.sort_unstable();
        assert_eq!(all, (-255..=255).collect::<Vec<_>>());
        assert_eq!(fractions(Level::Long), (0..1 << Format::BINARY16.fraction_width()).collect::<Vec<_>>());
        assert_eq!((differences(Level::Full).len(), fractions(Level::Full).len()), (31, 32));
    }
}
