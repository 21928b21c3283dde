//! Proofs that floating-point units are equivalent to IEEE 754's operations, which Yosys's command `symfpu` generates
//! for any format.
//!
//! A proof covers a unit between our encoders and our decoder, because units compute in the recoded format; the
//! operands in IEEE 754's format are free. As a negative control, the same commands must refute the claim for a unit
//! with a deliberate fault.

mod cases;
mod claim;
mod result;

pub use cases::{adder_proof, multiplier_proof};
pub use claim::{Claim, Operands, Subject};
pub use result::{ClaimResult, check};

use crate::error::Error;
use crate::request::{Level, Request};
use crate::sat::{Miter, Prover};
use crate::verdict::Verdict;
use raypath_float::Format;
use raypath_tools::{Cache, Key, pool};
use std::time::{Duration, Instant};

/// Proves the level's claims. Shards divide the claims.
///
/// # Errors
/// A program is missing or fails.
pub fn unit_proofs(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let prover = Prover::find()?;
    let claims: Vec<(Claim, bool)> = request.shard.of(claims(request.level)).map(|claim| (claim, true)).collect();
    let results = prove(&prover, &claims, None, request)?;
    let is_proved = |done: &&ClaimResult| done.outcome.is_ok();
    let proved: Vec<String> = results.iter().flatten().filter(is_proved).map(|done| done.claim.to_string()).collect();
    let covered = match proved.len() {
        0 => "nothing proved".to_string(),
        count => format!("{count} proofs, and as many faults refuted: {}", proved.join("; ")),
    };
    Ok(verdict(&results, covered, format!("with {}", prover.versions())))
}

/// Proves claims on all cores, those with `true` together with their deliberate fault. A claim without its fault is not
/// proved again if the cache has its proof. None for claims that were not reached when the run was stopped.
fn prove(
    prover: &Prover,
    claims: &[(Claim, bool)],
    cache: Option<&Cache>,
    request: &mut Request<'_>,
) -> Result<Vec<Option<ClaimResult>>, Error> {
    let limit = Duration::from_secs(request.level.pick(300, 1800, 7200));
    pool::map(claims, pool::ALL_CORES, request.proceed, |&(claim, with_fault), stop| {
        let Some(cache) = cache else { return check(prover, claim, with_fault, limit, stop) };
        let key = proof_key(&claim.miter(false)?, &prover.versions());
        if !with_fault && cache.has(&key) {
            return Ok(Some(ClaimResult { claim, outcome: Ok(()), found_fault: None, is_cached: true }));
        }
        let begin = Instant::now();
        let result = check(prover, claim, with_fault, limit, stop)?;
        if result.as_ref().is_some_and(|result| result.outcome.is_ok()) {
            cache.put(&key, &format!("{claim}: proved in {:.1} s", begin.elapsed().as_secs_f64()))?;
        }
        Ok(result)
    })
}

/// The name of a proof in the cache: a digest of the circuit's text, the commands and the programs' versions, so that
/// the proof of a unit that has changed since is not found.
fn proof_key(problem: &Miter, versions: &str) -> Key {
    let texts = problem.sources.iter().flat_map(|(name, text)| [name, text]).chain(&problem.commands);
    let parts: Vec<&str> = texts.map(String::as_str).chain([versions]).collect();
    Key::new("proof", &parts)
}

fn verdict(results: &[Option<ClaimResult>], covered: String, first_remark: String) -> Verdict {
    let faults = results.iter().flatten().filter_map(|result| result.found_fault.clone());
    Verdict {
        covered,
        failures: results.iter().flatten().filter_map(|result| result.outcome.clone().err()).collect(),
        remarks: std::iter::once(first_remark).chain(faults).collect(),
        is_stopped: results.iter().any(Option::is_none),
    }
}

/// The claims of a level, the longest proofs first. Each level includes the claims of the shorter ones.
fn claims(level: Level) -> impl Iterator<Item = Claim> {
    use Subject::{Add, AddParts, Compare, Mul, MulParts, RoundTrip, Sub};
    const CLAIMS: &[(Level, Subject, u32, u32)] = &[
        (Level::Full, Add, 5, 11),
        (Level::Full, Sub, 5, 11),
        (Level::Full, Mul, 8, 8),
        (Level::Full, Mul, 5, 8),
        (Level::Full, Add, 8, 11),
        (Level::Full, Sub, 8, 11),
        (Level::Full, Add, 8, 8),
        (Level::Full, Sub, 8, 8),
        (Level::Full, Mul, 5, 6),
        (Level::Full, Mul, 4, 5),
        (Level::Full, Mul, 5, 4),
        (Level::Full, Mul, 4, 4),
        (Level::Full, Add, 4, 4),
        (Level::Full, Compare, 8, 8),
        (Level::Full, Compare, 8, 11),
        (Level::Full, RoundTrip, 8, 8),
        (Level::Full, RoundTrip, 8, 11),
        (Level::Full, MulParts(2), 8, 24),
        (Level::Full, MulParts(3), 8, 24),
        (Level::Full, AddParts(2), 8, 24),
        (Level::Full, AddParts(3), 8, 24),
        (Level::Regression, Compare, 8, 24),
        (Level::Regression, Compare, 5, 11),
        (Level::Regression, Add, 3, 4),
        (Level::Regression, Sub, 3, 4),
        (Level::Regression, Mul, 3, 4),
        (Level::Regression, RoundTrip, 8, 24),
        (Level::Regression, RoundTrip, 5, 11),
    ];
    let chosen = CLAIMS.iter().filter(move |(least, ..)| level >= *least);
    chosen.filter_map(|&(_, subject, exponent, significand)| {
        Some(Claim::all(subject, Format::new(exponent, significand).ok()?))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_same_proof_has_the_same_key() {
        let key = |text: &str, command: &str, versions: &str| {
            let problem = Miter {
                name: "test".to_string(),
                sources: vec![("unit.sv".to_string(), text.to_string())],
                commands: vec![command.to_string()],
                inputs: Vec::new(),
            };
            proof_key(&problem, versions)
        };
        assert_eq!(key("x", "proc", "1"), key("x", "proc", "1"));
        for other in [key("y", "proc", "1"), key("x", "opt", "1"), key("x", "proc", "2")] {
            assert_ne!(other, key("x", "proc", "1"));
        }
    }
}
