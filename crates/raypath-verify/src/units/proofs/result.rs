//! Proving a claim, and refuting it for a faulty unit.

use super::claim::{Claim, Subject};
use crate::error::Error;
use crate::sat::{Miter, ProofResult, Prover};
use crate::units::bench::Simulated;
use raypath_float::{add, compare, mul};
use raypath_hdl::Module;
use raypath_tools::ToolError;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// The result of checking a claim.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClaimResult {
    /// The claim.
    pub claim: Claim,
    /// Whether the claim is proved; else why it is wrong or undecided.
    pub outcome: Result<(), String>,
    /// The remark on the fault and the operands that showed it, if the negative control ran and found it.
    pub found_fault: Option<String>,
    /// Whether the proof was in the cache.
    pub is_cached: bool,
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
        ProofResult::Proved { gates: 0 } if !claim.compares_own_units() => {
            Err(format!("{claim}: the circuit is empty"))
        }
        ProofResult::Proved { .. } => Ok(()),
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
    Ok(Some(ClaimResult { claim, outcome, found_fault, is_cached: false }))
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
        let simulated = match self.claim.subject {
            Subject::Add => simulate(add(format), encoded_b)?,
            Subject::Sub => simulate(add(format), encoded_b ^ top)?,
            Subject::Mul => simulate(mul(format), encoded_b)?,
            Subject::Compare => {
                let [less, equal, unordered] = Simulated::new(&compare(format)?)?.run([format.encode(a), encoded_b]);
                less << 2 | equal << 1 | unordered
            }
            Subject::RoundTrip => format.canonical(a),
            Subject::AddParts(_) => Simulated::new(&add(format)?)?.run::<1>([a, b])[0],
            Subject::MulParts(_) => Simulated::new(&mul(format)?)?.run::<1>([a, b])[0],
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
        match claim.subject {
            Subject::RoundTrip => write!(f, "{claim}: {a:#x} gives {ours:#x}, expected {wanted:#x}"),
            _ => write!(f, "{claim}: {a:#x} and {b:#x} give {ours:#x}, expected {wanted:#x}"),
        }
    }
}
