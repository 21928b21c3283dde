//! Proofs in cases, because one proof of all operands would take too long: binary32 addition, by the difference of the
//! exponents, and binary16 multiplication, by the fraction of the second operand.

use super::cache::ProofCache;
use super::claim::{Claim, Operands, Subject};
use super::result::{ClaimResult, check};
use crate::error::Error;
use crate::request::{Level, Request};
use crate::sat::Prover;
use crate::verdict::Verdict;
use raypath_float::Format;
use raypath_tools::pool;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// The folder of the proof cache, relative to the working directory.
pub const CASES_FOLDER: &str = "build/verify/proofs";

/// Proves binary32 addition for the level's differences of exponents; at level `long` for all 511, which cover all
/// pairs of operands. Cached proofs are not repeated. Shards divide the differences.
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
        // The fault changes a rounding that differences of exponents by 3 have.
        fault: case(3),
    };
    cases.prove(request)
}

/// Proves binary16 multiplication for the level's fractions of the second operand; at level `long` for all 1024, which
/// cover all pairs of operands. Cached proofs are not repeated. Shards divide the fractions.
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

/// The level's differences of biased exponents, the shortest proofs first.
fn differences(level: Level) -> Vec<i64> {
    let all = (0..=255).rev().flat_map(|distance| match distance {
        0 => vec![0],
        _ => vec![-distance, distance],
    });
    match level {
        Level::Regression => vec![-100],
        Level::Full => all.filter(|difference| difference % 16 == 0).collect(),
        Level::Long => all.collect(),
    }
}

/// The level's fractions.
fn fractions(level: Level) -> Vec<u64> {
    match level {
        Level::Regression => vec![0x2ab],
        // The step is odd, so that every bit is 0 in some fractions and 1 in others.
        Level::Full => (0..1024).step_by(33).collect(),
        Level::Long => (0..1024).collect(),
    }
}

/// A claim in cases, with a proof for each.
struct Cases {
    /// The claim, and how it is divided into cases.
    what: &'static str,
    /// The cases to prove.
    chosen: Vec<Claim>,
    /// The number of all cases.
    total: usize,
    /// The case in which the deliberate fault must be found.
    fault: Claim,
}

impl Cases {
    fn prove(self, request: &mut Request<'_>) -> Result<Verdict, Error> {
        let prover = Prover::find()?;
        let cache = ProofCache::open(Path::new(CASES_FOLDER), prover.versions())?;
        let shard = request.shard;
        let mine = self.chosen.iter().zip(0..).filter(|&(_, number)| shard.takes(number)).map(|(claim, _)| *claim);
        // The negative control runs every time.
        let work: Vec<(Claim, bool)> =
            std::iter::once((self.fault, true)).chain(mine.map(|claim| (claim, false))).collect();
        let limit = Duration::from_secs(request.level.pick(300, 1800, 7200));
        let one = |&(claim, with_fault): &(Claim, bool), stop: &AtomicBool| {
            prove_once(&prover, &cache, claim, with_fault, limit, stop)
        };
        let found = pool::map(&work, pool::ALL_CORES, request.proceed, one)?;
        let (first, rest) = found.split_at(1);
        let proved = rest.iter().flatten().filter(|case| case.result.outcome.is_ok()).count();
        let cached = rest.iter().flatten().filter(|case| case.is_cached).count();
        let mut remarks = vec![format!("with {}; {cached} of these proofs were cached", prover.versions())];
        remarks.extend(first.iter().flatten().filter_map(|case| case.result.fault_remark()));
        if self.chosen.len() < self.total {
            let level = request.level.name();
            remarks.push(format!("level {level} proves {} of {} cases", self.chosen.len(), self.total));
        }
        Ok(Verdict {
            covered: format!("{}, {proved} of {} cases proved", self.what, self.total),
            failures: found.iter().flatten().filter_map(|case| case.result.outcome.clone().err()).collect(),
            remarks,
            is_stopped: found.iter().any(Option::is_none),
        })
    }
}

/// The result of a case.
struct CaseResult {
    result: ClaimResult,
    /// Whether the proof was in the cache.
    is_cached: bool,
}

/// Proves a case, unless its proof is cached; none if the run was stopped.
fn prove_once(
    prover: &Prover,
    cache: &ProofCache,
    claim: Claim,
    with_fault: bool,
    limit: Duration,
    stop: &AtomicBool,
) -> Result<Option<CaseResult>, Error> {
    let problem = claim.miter(None)?;
    if !with_fault && cache.has(&problem) {
        let result = ClaimResult { claim, outcome: Ok(()), found_fault: None };
        return Ok(Some(CaseResult { result, is_cached: true }));
    }
    let begin = Instant::now();
    let Some(result) = check(prover, claim, with_fault, limit, stop)? else { return Ok(None) };
    if result.outcome.is_ok() {
        cache.add(&problem, &format!("{claim}: proved in {:.1} s", begin.elapsed().as_secs_f64()))?;
    }
    Ok(Some(CaseResult { result, is_cached: false }))
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
