//! Proofs in cases, because one proof of all operands would take too long: binary32 addition, by the difference of the
//! exponents, and binary16 multiplication, by the fraction of the second operand.

use super::claim::{Claim, Operands, Subject};
use super::{ClaimResult, prove, verdict};
use crate::error::Error;
use crate::request::{Level, Request};
use crate::sat::Prover;
use crate::verdict::Verdict;
use raypath_float::Format;
use raypath_tools::Cache;
use std::path::Path;

/// The folder of the proof cache, relative to the working directory.
const CASES_FOLDER: &str = "build/verify/proofs";

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
        let cache = Cache::new(Path::new(CASES_FOLDER));
        // The negative control runs every time.
        let mine = request.shard.of(&self.chosen).map(|claim| (*claim, false));
        let work: Vec<(Claim, bool)> = std::iter::once((self.fault, true)).chain(mine).collect();
        let results = prove(&prover, &work, Some(&cache), request)?;
        let rest = || results.iter().skip(1).flatten();
        let proved = rest().filter(|case| case.outcome.is_ok()).count();
        let cached = rest().filter(|case: &&ClaimResult| case.is_cached).count();
        let covered = format!("{}, {proved} of {} cases proved", self.what, self.total);
        let remark = format!("with {}; {cached} of these proofs were cached", prover.versions());
        let mut verdict = verdict(&results, covered, remark);
        if self.chosen.len() < self.total {
            let (level, chosen) = (request.level.name(), self.chosen.len());
            verdict.remarks.push(format!("level {level} proves {chosen} of {} cases", self.total));
        }
        Ok(verdict)
    }
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
