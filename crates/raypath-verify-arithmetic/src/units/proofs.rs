//! Proofs that floating-point units are equivalent to IEEE 754's operations, which Yosys's command `symfpu` generates
//! for any format.
//!
//! A proof covers a unit between our encoders and our decoder, because units compute in the recoded format; the
//! operands in IEEE 754's format are free. As a negative control, the same commands must refute the claim for a unit
//! with a deliberate fault.

mod claim;
mod lemma;
mod linear;
mod product;
mod short;
mod sum;
mod theorem;

pub use claim::{Claim, Form, Operands, Subject};
pub use theorem::multiplication;

use crate::units::bench::Simulated;
use raypath_float::{
    DivSqrt, Format, Narrow, add, compare, div, mul, mul_inferred_parts, mul_narrow_parts, narrow, sqrt, sum_parts,
};
use raypath_hdl::Module;
use raypath_tools::{ToolError, pool};
use raypath_verify::sat::{Certificate, Miter, ProofResult, Prover};
use raypath_verify::{Error, Level, Progress, Request, Verdict};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Proves the level's claims. Shards divide the claims.
///
/// # Errors
/// A program is missing or fails.
pub fn unit_proofs(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let claims: Vec<(Claim, bool)> = claims(request.level).map(|claim| (claim, true)).collect();
    let shard = request.shard;
    let (results, versions) = prove(&claims, |number| shard.takes(number), request)?;
    let is_proved = |done: &&ClaimResult| done.outcome.is_ok();
    let proved: Vec<String> = results.iter().flatten().filter(is_proved).map(|done| done.claim.to_string()).collect();
    let covered = match proved.len() {
        0 => "nothing proved".to_string(),
        count => format!("{count} proofs, and as many faults refuted: {}", proved.join("; ")),
    };
    Ok(verdict(&results, covered, format!("with {versions}")))
}

/// The result of a claim in a part: the fields of [`ClaimResult`] but the claim, which its number gives.
type Proof = (Result<Certificate, String>, Option<String>);

/// How long CaDiCaL may take for the certificate of a proof.
fn certificate_limit(level: Level) -> Duration {
    Duration::from_secs(level.pick(20, 600, 3600))
}

/// A remark on the proofs that have certificates, and on those that have none.
fn certificates<'a>(proofs: impl Iterator<Item = (&'a str, &'a Certificate)>) -> String {
    let (checked, others): (Vec<_>, Vec<_>) =
        proofs.partition(|(_, certificate)| matches!(certificate, Certificate::Checked { .. }));
    let others: Vec<&str> = others.into_iter().map(|(name, _)| name).collect();
    let without = match others.is_empty() {
        true => String::new(),
        false => format!("; none within the limit for {}", others.join("; ")),
    };
    format!("{} proofs repeated by CaDiCaL, each step of their certificates checked{without}", checked.len())
}

/// Proves the claims whose numbers are `mine` on all cores, those with `true` together with their deliberate fault.
/// Returns the results in the order of the claims, and the versions of the programs. None for claims that were not
/// reached when the run was stopped.
fn prove(
    claims: &[(Claim, bool)],
    mine: impl Fn(u64) -> bool,
    request: &mut Request<'_>,
) -> Result<(Vec<Option<ClaimResult>>, String), Error> {
    let limit = Duration::from_secs(request.level.pick(300, 1800, 7200));
    let shards = request.parts.phase(|| {
        let prover = Prover::with_certificates(certificate_limit(request.level))?;
        let numbers: Vec<u64> = (0..claims.len() as u64).filter(|&number| mine(number)).collect();
        let chosen: Vec<(Claim, bool)> = numbers.iter().map(|&number| claims[number as usize]).collect();
        let results = prove_all(&prover, &chosen, limit, request.proceed)?;
        let proof = |result: ClaimResult| (result.outcome, result.found_fault);
        let proofs: Vec<(u64, Option<Proof>)> =
            numbers.into_iter().zip(results).map(|(number, result)| (number, result.map(proof))).collect();
        Ok::<_, Error>((prover.versions(), proofs))
    })?;
    let versions: BTreeSet<&str> = shards.iter().map(|(versions, _)| versions.as_str()).collect();
    let versions = versions.into_iter().collect::<Vec<_>>().join("; ");
    // A claim that all shards prove, because it is a negative control, counts once.
    let proofs: BTreeMap<u64, Option<Proof>> = shards.into_iter().flat_map(|(_, proofs)| proofs).collect();
    let result = |(number, proof): (u64, Option<Proof>)| {
        let (claim, _) = *claims.get(number as usize)?;
        Some(proof.map(|(outcome, found_fault)| ClaimResult { claim, outcome, found_fault }))
    };
    Ok((proofs.into_iter().filter_map(result).collect(), versions))
}

/// Proves claims on all cores.
fn prove_all(
    prover: &Prover,
    claims: &[(Claim, bool)],
    limit: Duration,
    proceed: &mut dyn FnMut(Progress) -> bool,
) -> Result<Vec<Option<ClaimResult>>, Error> {
    pool::map(claims, pool::ALL_CORES, proceed, |&(claim, with_fault), stop| {
        check(prover, claim, with_fault, limit, stop)
    })
}

fn verdict(results: &[Option<ClaimResult>], covered: String, first_remark: String) -> Verdict {
    let faults = results.iter().flatten().filter_map(|result| result.found_fault.clone());
    let proved: Vec<(String, &Certificate)> = results
        .iter()
        .flatten()
        .filter_map(|result| Some((result.claim.to_string(), result.outcome.as_ref().ok()?)))
        .collect();
    let certified = certificates(proved.iter().map(|(name, certificate)| (name.as_str(), *certificate)));
    Verdict {
        covered,
        failures: results.iter().flatten().filter_map(|result| result.outcome.clone().err()).collect(),
        remarks: [first_remark, certified].into_iter().chain(faults).collect(),
        is_stopped: results.iter().any(Option::is_none),
    }
}

/// The result of checking a claim.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClaimResult {
    /// The claim.
    pub claim: Claim,
    /// The certificate of the proof; else why the claim is wrong or undecided.
    pub outcome: Result<Certificate, String>,
    /// The remark on the fault and the operands that showed it, if the negative control ran and found it.
    pub found_fault: Option<String>,
}

/// Proves a claim. With `with_fault`, also refutes it by the same commands for the unit with the subject's fault.
/// `limit` applies to each. None if the run was stopped.
///
/// # Errors
/// A program is missing or fails, or a counterexample is none.
pub fn check(
    prover: &Prover,
    claim: Claim,
    with_fault: bool,
    limit: Duration,
    stop: &AtomicBool,
) -> Result<Option<ClaimResult>, Error> {
    let faults: &[bool] = if with_fault { &[false, true] } else { &[false] };
    let miters: Vec<Miter> = faults.iter().map(|with_fault| claim.miter(*with_fault)).collect::<Result<_, _>>()?;
    let results = prover.solve(&miters, limit, stop)?;
    if results.contains(&ProofResult::Stopped) {
        return Ok(None);
    }
    let mut outcome = match &results[0] {
        // Unit and reference share no logic: if they are equal before any proof, something is missing.
        ProofResult::Proved { gates: 0, .. } if !claim.compares_own_units() => {
            Err(format!("{claim}: the circuit is empty"))
        }
        ProofResult::Proved { certificate, .. } => Ok(certificate.clone()),
        ProofResult::Refuted(values) => Err(Counterexample::of(prover, &claim, &miters[0], values)?.to_string()),
        ProofResult::Undecided(why) => Err(format!("{claim}: undecided, {why}")),
        ProofResult::Stopped => Err(format!("{claim}: stopped")),
    };
    let mut found_fault = None;
    if let (Some(result), Some(miter)) = (results.get(1), miters.get(1)) {
        match result {
            ProofResult::Refuted(values) => {
                let example = Counterexample::of(prover, &claim, miter, values)?;
                example.confirm()?;
                let (from, to) = claim.subject.fault();
                found_fault = Some(format!("a deliberate fault is found: with {to} for {from}, {example}"));
            }
            other => outcome = Err(format!("{claim}: a deliberate fault is not found: {other:?}")),
        }
    }
    Ok(Some(ClaimResult { claim, outcome, found_fault }))
}

/// Operands for which the results of unit and reference differ.
struct Counterexample {
    claim: Claim,
    a: u64,
    b: u64,
    ours: u64,
    wanted: u64,
}

impl Counterexample {
    /// Lets Yosys evaluate both sides; an error if they do not differ.
    fn of(prover: &Prover, claim: &Claim, miter: &Miter, values: &BTreeMap<String, u64>) -> Result<Self, Error> {
        let shown = prover.evaluate(miter, values, &["a", "b", "ours", "wanted", "valid"])?;
        match shown[..] {
            [a, b, ours, wanted, 1] if ours != wanted => Ok(Self { claim: *claim, a, b, ours, wanted }),
            _ => {
                let found = format!("{claim}: not a counterexample: {values:x?} gives {shown:x?}");
                Err(ToolError::unexpected("abc", found, "operands for which the sides differ").into())
            }
        }
    }

    /// Checks that the unit without the fault, simulated, gives the reference's result.
    fn confirm(&self) -> Result<(), Error> {
        let (format, &Self { a, b, .. }) = (self.claim.format, self);
        let simulate = |unit: Result<Arc<Module>, raypath_hdl::Error>, b| -> Result<_, Error> {
            let [result] = Simulated::new(&unit?)?.run([format.encode(a), b]);
            Ok(format.decode(result))
        };
        let top = 1 << (format.recoded_width() - 1);
        let encoded_b = format.encode(b);
        let mul_inferred = || Ok(mul_inferred_parts(format, 1, false)?.remove(0));
        let simulated = match self.claim.subject {
            Subject::Add => simulate(add(format), encoded_b)?,
            Subject::Sub => simulate(add(format), encoded_b ^ top)?,
            Subject::Mul => simulate(mul(format), encoded_b)?,
            Subject::MulInferred => simulate(mul_inferred(), encoded_b)?,
            Subject::Div => simulate(div(format), encoded_b)?,
            Subject::Sqrt => simulate(sqrt(format), 0)?,
            Subject::Divided(function, _) => {
                // The square root has one input.
                let unit = function.parts(format, 1)?.remove(0);
                Simulated::new(&unit)?.run::<1>([a, b])[0]
            }
            Subject::Compare => {
                let [less, equal, unordered] = Simulated::new(&compare(format)?)?.run([format.encode(a), encoded_b]);
                less << 2 | equal << 1 | unordered
            }
            Subject::RoundTrip => format.canonical(a),
            Subject::ShortProduct(to) => {
                let short = format.narrowed(to.bits)?;
                let unit = mul_narrow_parts(format, to.bits, to, 1)?.remove(0);
                short.decode(Simulated::new(&unit)?.run::<1>([a, b].map(|operand| short.encode(operand)))[0])
            }
            Subject::Shortening(to) => {
                let [result] = Simulated::new(&narrow(format, to)?)?.run([format.encode(a)]);
                format.narrowed(to.bits)?.decode(result)
            }
            Subject::Sum(terms) => {
                let width = format.ieee_width();
                let words = (0..terms).map(|term| format.encode(a >> (term * width) & ((1 << width) - 1)));
                format.decode(Simulated::new(&sum_parts(format, terms, 1)?.remove(0))?.run::<1>(words)[0])
            }
            Subject::AddParts(_) => Simulated::new(&add(format)?)?.run::<1>([a, b])[0],
            Subject::MulParts(_) => Simulated::new(&mul(format)?)?.run::<1>([a, b])[0],
            Subject::MulInferredParts(_) => Simulated::new(&mul_inferred()?)?.run::<1>([a, b])[0],
        };
        if simulated == self.wanted {
            return Ok(());
        }
        let found = format!("{self}; but the simulator gives {simulated:#x}");
        Err(ToolError::unexpected("yosys", found, "the reference and the unit without a fault to agree").into())
    }
}

impl std::fmt::Display for Counterexample {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { claim, a, b, ours, wanted } = self;
        match claim.is_unary() {
            true => write!(f, "{claim}: {a:#x} gives {ours:#x}, expected {wanted:#x}"),
            false => write!(f, "{claim}: {a:#x} and {b:#x} give {ours:#x}, expected {wanted:#x}"),
        }
    }
}

/// The claims of a level, the longest proofs first. Each level includes the claims of the shorter ones.
fn claims(level: Level) -> impl Iterator<Item = Claim> {
    use Subject::{
        Add, AddParts, Compare, Div, Divided, Mul, MulInferred, MulInferredParts, MulParts, RoundTrip, ShortProduct,
        Shortening, Sqrt, Sub, Sum,
    };
    const fn product(bits: u32, away: bool) -> Subject {
        ShortProduct(Narrow { bits, away, margin: 0 })
    }
    const fn rounding(bits: u32, away: bool, margin: u32) -> Subject {
        Shortening(Narrow { bits, away, margin })
    }
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
        (Level::Full, MulInferred, 8, 8),
        (Level::Full, MulInferred, 5, 6),
        (Level::Full, Sum(3), 3, 4),
        (Level::Full, Sum(3), 3, 3),
        (Level::Full, Mul, 4, 5),
        (Level::Full, Mul, 5, 4),
        (Level::Full, Mul, 4, 4),
        (Level::Full, Add, 4, 4),
        (Level::Full, Compare, 8, 8),
        (Level::Full, Compare, 8, 11),
        (Level::Full, RoundTrip, 8, 8),
        (Level::Full, RoundTrip, 8, 11),
        (Level::Full, Div, 4, 6),
        (Level::Full, Div, 5, 4),
        (Level::Full, Sqrt, 5, 11),
        (Level::Full, Sqrt, 8, 8),
        (Level::Full, Divided(DivSqrt::Quotient, Form::Parts(14)), 8, 24),
        (Level::Full, Divided(DivSqrt::Quotient, Form::Iterative(1)), 8, 24),
        // No answer within 30 minutes on a busy machine.
        (Level::Long, Divided(DivSqrt::Quotient, Form::Iterative(3)), 8, 24),
        (Level::Full, Divided(DivSqrt::Root, Form::Iterative(1)), 8, 24),
        (Level::Full, MulParts(2), 8, 24),
        (Level::Full, MulParts(3), 8, 24),
        (Level::Full, MulInferredParts(2), 8, 24),
        (Level::Full, MulInferredParts(3), 8, 24),
        (Level::Full, AddParts(2), 8, 24),
        (Level::Full, AddParts(3), 8, 24),
        // Exact products, and products that are rounded to nearest first.
        (Level::Full, product(6, false), 8, 12),
        (Level::Full, product(6, true), 8, 12),
        (Level::Full, product(6, false), 5, 9),
        (Level::Full, product(6, true), 5, 9),
        (Level::Regression, product(4, false), 5, 8),
        (Level::Regression, product(4, true), 5, 8),
        (Level::Regression, product(4, false), 4, 6),
        (Level::Regression, product(4, true), 4, 6),
        (Level::Regression, rounding(13, false, 0), 8, 24),
        (Level::Regression, rounding(13, true, 0), 8, 24),
        (Level::Regression, rounding(13, false, 4), 8, 24),
        (Level::Regression, rounding(13, true, 4), 8, 24),
        (Level::Regression, Compare, 8, 24),
        (Level::Regression, Compare, 5, 11),
        (Level::Regression, Add, 3, 4),
        (Level::Regression, Sub, 3, 4),
        (Level::Regression, Mul, 3, 4),
        (Level::Regression, MulInferred, 3, 4),
        (Level::Regression, Div, 3, 4),
        (Level::Regression, Sqrt, 3, 4),
        (Level::Regression, Divided(DivSqrt::Quotient, Form::Iterative(2)), 8, 24),
        (Level::Regression, Divided(DivSqrt::Root, Form::Iterative(2)), 8, 24),
        (Level::Regression, RoundTrip, 8, 24),
        (Level::Regression, RoundTrip, 5, 11),
    ];
    let chosen = CLAIMS.iter().filter(move |(least, ..)| level >= *least);
    chosen.filter_map(|&(_, subject, exponent, significand)| {
        Some(Claim::all(subject, Format::new(exponent, significand).ok()?))
    })
}

/// Proves binary32 addition in the level's cases; at level `full` in all, which cover all pairs of operands. Shards divide the cases.
///
/// # Errors
/// A program is missing or fails.
pub fn adder_proof(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let case = |operands| Claim { subject: Subject::Add, format: Format::BINARY32, operands };
    let all = adder_cases();
    let cases = Cases {
        what: "binary32 addition, by difference of exponents",
        total: all.len(),
        chosen: match request.level {
            // A short one.
            Level::Regression => vec![case(Operands::ExponentDifference(-25))],
            Level::Full | Level::Long => all.into_iter().map(case).collect(),
        },
        // The fault changes a rounding that differences of exponents by 3 have.
        fault: case(Operands::ExponentDifference(3)),
    };
    cases.prove(request)
}

/// Cases that cover all pairs of operands of binary32: exponents far apart, the longest proofs, and each smaller
/// difference.
fn adder_cases() -> Vec<Operands> {
    // From this difference on, the smaller operand is below the guard bits of the larger one.
    let least = Format::BINARY32.significand() + 3;
    let far = [true, false].map(|first| Operands::Apart { least, first });
    let near = (1 - i64::from(least)..i64::from(least)).map(Operands::ExponentDifference);
    far.into_iter().chain(near).collect()
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
        let cases = self.chosen.iter().map(|claim| (*claim, false));
        let work: Vec<(Claim, bool)> = std::iter::once((self.fault, true)).chain(cases).collect();
        // The negative control runs every time, in every shard.
        let shard = request.shard;
        let is_mine = |number: u64| number.checked_sub(1).is_none_or(|case| shard.takes(case));
        let (results, versions) = prove(&work, is_mine, request)?;
        let proved = results.iter().skip(1).flatten().filter(|case| case.outcome.is_ok()).count();
        let covered = format!("{}, {proved} of {} cases proved", self.what, self.total);
        let mut verdict = verdict(&results, covered, format!("with {versions}"));
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
    fn the_cases_of_addition_leave_no_difference_out() {
        let cases = adder_cases();
        let covers = |difference: i64| {
            let number = cases.iter().filter(|case| match **case {
                Operands::All => true,
                Operands::ExponentDifference(one) => one == difference,
                Operands::Apart { least, first } => (if first { difference } else { -difference }) >= least.into(),
            });
            number.count() == 1
        };
        assert!((-255..=255).all(covers));
        assert_eq!(cases.len(), 55);
    }
}
