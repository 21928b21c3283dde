//! Proofs by SAT about floating-point units. Each claim has a deliberate fault, which the same commands must refute.

mod claim;
mod digits;
mod lemma;
mod linear;
mod product;
mod short;
mod sum;
mod unit_claim;
mod words;

pub use claim::Claim;
pub use unit_claim::{Operands, Unit, UnitClaim};

use product::Multiplier;
use raypath_float::{DivSqrt, Format, Narrow};
use raypath_tools::ToolError;
use raypath_verify::sat::{Miter, ProofResult, Prover};
use raypath_verify::{Error, Level, Progress, Request, Verdict};
use raypath_work::pool;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// A claim and its deliberate fault.
pub struct Proof {
    /// What it belongs to, in a report.
    pub subject: String,
    /// The circuit that is 0 if the claim holds.
    pub claim: Miter,
    /// The circuits that are not, because of a fault.
    pub faults: Vec<Miter>,
    /// Whether the claim may hold before any proof, because both of its sides have one description.
    pub is_alike: bool,
}

/// What a shard found.
#[derive(Serialize, Deserialize)]
struct Part {
    versions: String,
    /// The claims of all shards.
    total: usize,
    /// By the number of the claim.
    results: Vec<(u64, Found)>,
    is_stopped: bool,
}

/// What was found of a claim.
#[derive(Serialize, Deserialize)]
struct Found {
    subject: String,
    /// The faults that were refuted.
    faults: usize,
    /// What is wrong, if anything.
    problem: Option<String>,
}

/// Proves claims and refutes their faults. Shards divide the claims; Yosys starts once for `batch` of them.
///
/// # Errors
/// Those of `proofs`; a program is missing or fails.
pub fn prove(
    request: &mut Request<'_>,
    batch: usize,
    proofs: impl FnOnce(&mut dyn FnMut(Progress) -> bool) -> Result<Vec<Proof>, Error>,
) -> Result<Verdict, Error> {
    let (level, shard) = (request.level, request.shard);
    let limit = Duration::from_secs(level.pick(300, 1800, 7200));
    let parts = request.parts.phase(|| {
        let prover = Prover::find()?;
        let proofs = proofs(request.proceed)?;
        let mine: Vec<(u64, &Proof)> = (0..).zip(&proofs).filter(|(number, _)| shard.takes(*number)).collect();
        let batches: Vec<&[(u64, &Proof)]> = mine.chunks(batch).collect();
        let found =
            pool::map(&batches, pool::ALL_CORES, request.proceed, |batch, stop| solve(&prover, batch, limit, stop))?;
        let is_stopped = found.iter().any(Option::is_none);
        let results = found.into_iter().flatten().flatten().collect();
        Ok::<_, Error>(Part { versions: prover.versions(), total: proofs.len(), results, is_stopped })
    })?;
    let results: BTreeMap<u64, &Found> =
        parts.iter().flat_map(|part| part.results.iter().map(|(number, found)| (*number, found))).collect();
    let proved: Vec<&Found> = results.values().copied().filter(|found| found.problem.is_none()).collect();
    let mut subjects: Vec<(&str, usize)> = Vec::new();
    for Found { subject, .. } in &proved {
        match subjects.iter_mut().find(|(known, _)| known == subject) {
            Some((_, count)) => *count += 1,
            None => subjects.push((subject, 1)),
        }
    }
    let subjects: Vec<String> = subjects.iter().map(|(subject, count)| format!("{subject} ({count})")).collect();
    let faults: usize = proved.iter().map(|found| found.faults).sum();
    let total = parts.first().map_or(0, |part| part.total);
    let (count, subjects) = (proved.len(), subjects.join("; "));
    Ok(Verdict {
        covered: format!("{count} of {total} claims proved, and {faults} faults refuted: {subjects}"),
        failures: results.values().filter_map(|found| found.problem.clone()).collect(),
        remarks: parts.first().map(|part| format!("with {}", part.versions)).into_iter().collect(),
        is_stopped: parts.iter().any(|part| part.is_stopped),
    })
}

/// The results of some proofs; none if the run was stopped.
fn solve(
    prover: &Prover,
    proofs: &[(u64, &Proof)],
    limit: Duration,
    stop: &AtomicBool,
) -> Result<Option<Vec<(u64, Found)>>, Error> {
    let miters: Vec<Miter> =
        proofs.iter().flat_map(|(_, proof)| std::iter::once(&proof.claim).chain(&proof.faults)).cloned().collect();
    let results = prover.solve(&miters, limit, stop)?;
    if results.contains(&ProofResult::Stopped) {
        return Ok(None);
    }
    let mut results = results.into_iter();
    let judged = proofs.iter().map(|(number, proof)| {
        let name = &proof.claim.name;
        let wrong = match results.next() {
            // Unit and reference share no logic: if they are equal before any proof, something is missing.
            Some(ProofResult::Proved { gates: 0 }) if !proof.is_alike => Some(format!("{name}: the circuit is empty")),
            Some(ProofResult::Proved { .. }) => None,
            Some(ProofResult::Refuted(values)) => Some(format!("{name}: refuted by {values:x?}")),
            other => Some(format!("{name}: undecided, {other:?}")),
        };
        let faults = results.by_ref().take(proof.faults.len());
        let missed = faults.filter(|fault| !matches!(fault, ProofResult::Refuted(_))).count();
        let missed = (missed > 0).then(|| format!("{name}: a deliberate fault is not found"));
        (*number, Found { subject: proof.subject.clone(), faults: proof.faults.len(), problem: wrong.or(missed) })
    });
    Ok(Some(judged.collect()))
}

/// Proves the level's claims about units.
///
/// # Errors
/// A program is missing or fails.
pub fn unit_proofs(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let level = request.level;
    prove(request, 2, |_| claims(level).map(|(subject, format)| proof(subject, format)).collect())
}

fn proof(subject: UnitClaim, format: Format) -> Result<Proof, Error> {
    let claim = subject.claim(format)?;
    // Only some differences of exponents have the rounding that the adder's fault changes.
    let has_fault = match subject {
        UnitClaim::Rounds(_, operands) => matches!(operands, Operands::All | Operands::Difference(3)),
        _ => true,
    };
    let faults = if has_fault { vec![claim.miter(true)?] } else { Vec::new() };
    let subject = claim.name.split(", ").next().unwrap_or_default().to_string();
    Ok(Proof { subject, claim: claim.miter(false)?, faults, is_alike: claim.is_alike })
}

/// Proves the lemmas of the level's theorems about multipliers.
///
/// # Errors
/// A program is missing or fails; a product does not follow from its lemmas.
pub fn multiplication(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let level = request.level;
    prove(request, 6, |_| {
        let mut proofs = Vec::new();
        for multiplier in multipliers(level) {
            let (subject, (lemmas, follows)) = (multiplier.to_string(), multiplier.theorem()?);
            let problem =
                |why| ToolError::unexpected("raypath", format!("{subject}: {why}"), "that the product follows");
            follows.map_err(problem)?;
            for lemma in lemmas {
                let [claim, fault] = [false, true].map(|with_fault| lemma.miter(&subject, with_fault));
                proofs.push(Proof { subject: subject.clone(), claim: claim?, faults: vec![fault?], is_alike: true });
            }
        }
        Ok(proofs)
    })
}

/// The claims of a level, in the formats of presets and in small ones, whose proofs are short. Each level includes the
/// claims of the shorter ones.
fn claims(level: Level) -> impl Iterator<Item = (UnitClaim, Format)> {
    use Unit::{Add, Div, Mul, MulDsp, MulInferred, Sqrt};
    use UnitClaim::{
        AddsIgnoredBits, BeginsDigits, Canonises, Compares, ComparesIgnoredBits, ComparesShort, DecodesShort, Encodes,
        Iterative, MultipliesIgnoredBits, Parts, RoundTrip, Rounds, RoundsDigits, ShortProduct, ShortProductParts,
        Shortening, Sum, WithFlags,
    };
    const fn rounds(unit: Unit) -> UnitClaim {
        Rounds(unit, Operands::All)
    }
    const fn product(bits: u32, away: bool) -> UnitClaim {
        ShortProduct(Narrow { bits, away, margin: 0 })
    }
    const fn rounding(bits: u32, away: bool, margin: u32) -> UnitClaim {
        Shortening(Narrow { bits, away, margin })
    }
    const NARROW: Narrow = Narrow { bits: 13, away: true, margin: 0 };
    // Yosys's symfpu refuses significands of 3 bits.
    const SMALL: &[(u32, u32)] = &[(3, 4), (3, 5), (4, 4)];
    const SHORT: &[(u32, u32)] = &[(5, 8), (4, 6), (4, 5)];
    const OTHERS: &[(u32, u32)] = &[(8, 8), (8, 11), (11, 24), (8, 4), (4, 7)];
    const BINARY: &[(u32, u32)] = &[(8, 24), (5, 11)];
    const BINARY32: &[(u32, u32)] = &[(8, 24)];
    const FULL: &[(UnitClaim, &[(u32, u32)])] = &[
        (rounds(Add), &[(5, 11), (8, 11), (8, 8), (4, 7), (8, 4)]),
        (rounds(Mul), &[(8, 8), (5, 6), (8, 4)]),
        (rounds(MulInferred), &[(5, 6)]),
        (Sum(3), &[(3, 4), (3, 3)]),
        (rounds(Div), &[(4, 6), (5, 4)]),
        (rounds(Sqrt), &[(5, 11), (8, 8)]),
        (Compares, OTHERS),
        (RoundTrip, OTHERS),
        (Encodes, OTHERS),
        (Canonises, OTHERS),
        (Parts(Div, 14), BINARY32),
        (Iterative(DivSqrt::Quotient, 1), BINARY32),
        (Iterative(DivSqrt::Root, 1), BINARY32),
        (WithFlags(MulInferred), BINARY32),
        (product(6, false), &[(8, 12), (5, 9)]),
        (product(6, true), &[(8, 12), (5, 9)]),
        (ShortProductParts(NARROW, 2), BINARY32),
        (ShortProductParts(NARROW, 3), BINARY32),
        (rounding(8, false, 1), BINARY32),
        (rounding(8, true, 1), BINARY32),
    ];
    const REGRESSION: &[(UnitClaim, &[(u32, u32)])] = &[
        (Parts(Add, 10), BINARY),
        (Parts(Mul, 8), BINARY),
        (Parts(MulInferred, 8), BINARY32),
        (Parts(MulDsp, 8), BINARY32),
        (WithFlags(Add), BINARY),
        (WithFlags(Mul), BINARY32),
        (RoundsDigits(DivSqrt::Quotient), BINARY32),
        (RoundsDigits(DivSqrt::Root), BINARY32),
        (BeginsDigits(DivSqrt::Quotient), BINARY32),
        (BeginsDigits(DivSqrt::Root), BINARY32),
        (AddsIgnoredBits, BINARY32),
        (MultipliesIgnoredBits, BINARY32),
        (ComparesIgnoredBits, BINARY32),
        (product(4, false), SHORT),
        (product(4, true), SHORT),
        (rounding(3, true, 4), &[(5, 8), (4, 6)]),
        (rounding(3, false, 4), &[(5, 8), (4, 6)]),
        (rounding(13, false, 0), BINARY32),
        (rounding(13, true, 0), BINARY32),
        (rounding(13, false, 4), BINARY32),
        (rounding(13, true, 4), BINARY32),
        (ComparesShort(13), BINARY32),
        (DecodesShort(13), BINARY32),
        (Compares, BINARY),
        (rounds(Add), SMALL),
        (rounds(Mul), SMALL),
        (rounds(MulInferred), &[(3, 4)]),
        (rounds(Div), &[(3, 4)]),
        (rounds(Sqrt), &[(3, 4)]),
        (Iterative(DivSqrt::Quotient, 2), BINARY32),
        (Iterative(DivSqrt::Root, 2), BINARY32),
        (RoundTrip, BINARY),
        (Encodes, BINARY),
        (Canonises, BINARY),
    ];
    let is_full = level >= Level::Full;
    let adder = adder_cases().into_iter().filter(move |case| is_full || matches!(case, Operands::Difference(-25 | 3)));
    let adder = adder.map(|operands| (Rounds(Add, operands), Format::BINARY32));
    let tables = [if is_full { FULL } else { &[] }, REGRESSION].into_iter().flatten();
    let rows = tables.flat_map(|(subject, sizes)| sizes.iter().map(move |size| (*subject, *size)));
    // Those in the most parts are in the table.
    let divided = [(Add, 10), (Mul, 8), (MulInferred, 8), (MulDsp, 8)].into_iter().filter(move |_| is_full);
    let divided = divided.flat_map(|(unit, most)| (2..most).map(move |count| (Parts(unit, count), Format::BINARY32)));
    adder.chain(divided).chain(rows.filter_map(|(subject, (e, s))| Some((subject, Format::new(e, s).ok()?))))
}

/// The multipliers of a level. Each level includes those of the shorter ones.
fn multipliers(level: Level) -> impl Iterator<Item = Multiplier> {
    /// Level, widths, whether with `*`, the bits of a short factor or 0, and whether with flags.
    const MULTIPLIERS: &[(Level, u32, u32, bool, u32, bool)] = &[
        (Level::Regression, 8, 24, false, 0, true),
        (Level::Full, 8, 24, true, 0, true),
        (Level::Full, 8, 24, false, 0, false),
        (Level::Regression, 8, 24, true, 0, false),
        (Level::Full, 8, 24, false, 8, false),
        (Level::Full, 8, 24, true, 8, false),
        (Level::Full, 8, 24, false, 13, false),
        (Level::Full, 11, 24, false, 0, false),
        (Level::Full, 5, 11, false, 0, true),
        (Level::Full, 5, 11, true, 0, true),
        (Level::Full, 8, 11, false, 0, true),
        (Level::Full, 8, 8, false, 0, true),
        (Level::Full, 7, 17, false, 0, false),
        (Level::Full, 5, 10, false, 0, false),
        (Level::Full, 5, 9, false, 4, false),
        (Level::Full, 4, 6, false, 0, true),
        (Level::Full, 3, 4, false, 0, false),
    ];
    let chosen = MULTIPLIERS.iter().filter(move |(least, ..)| level >= *least);
    chosen.filter_map(|&(_, exponent, significand, inferred, short, with_flags)| {
        let format = Format::new(exponent, significand).ok()?;
        Some(Multiplier { format, inferred, short: (short > 0).then_some(short), with_flags })
    })
}

/// Cases that cover all pairs of operands of binary32: exponents far apart, the longest proofs, and each smaller
/// difference.
fn adder_cases() -> Vec<Operands> {
    // From this difference on, the smaller operand is below the guard bits of the larger one.
    let least = Format::BINARY32.significand() + 3;
    let near = (1 - i64::from(least)..i64::from(least)).map(Operands::Difference);
    [Operands::FirstLarger(least), Operands::SecondLarger(least)].into_iter().chain(near).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cases_of_addition_leave_no_difference_out() {
        let cases = adder_cases();
        let covers = |difference: i64| {
            let number = cases.iter().filter(|case| match **case {
                Operands::All => true,
                Operands::Difference(one) => one == difference,
                Operands::FirstLarger(least) => difference >= least.into(),
                Operands::SecondLarger(least) => -difference >= least.into(),
            });
            number.count() == 1
        };
        assert!((-255..=255).all(covers));
        assert_eq!(cases.len(), 55);
    }
}
