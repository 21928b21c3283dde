//! A claim proved, and the same claim about a faulty unit refuted.

use super::claim::{Claim, Fault, Subject};
use crate::Error;
use crate::proof::{Answer, Problem, Prover};
use raypath_float::{add, compare, mul};
use raypath_hdl::Simulator;
use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// What came of a claim.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Judged {
    /// The claim.
    pub claim: Claim,
    /// Whether the unit is as claimed; else why not, or why that is not known.
    pub result: Result<(), String>,
    /// How the fault was seen, if one was to be.
    pub seen: Option<String>,
}

/// Proves a claim, and refutes it for the unit with the subject's fault where `with_fault` is set: in the same way, by the
/// same commands. `limit` is for each. Nothing where it was stopped.
pub fn judge(
    prover: &Prover,
    claim: Claim,
    with_fault: bool,
    limit: Duration,
    stop: &AtomicBool,
) -> Result<Option<Judged>, Error> {
    let faults: &[Option<Fault>] = if with_fault { &[None, Some(claim.subject.fault())] } else { &[None] };
    let problems: Vec<Problem> = faults.iter().map(|fault| claim.problem(*fault)).collect::<Result<_, _>>()?;
    let answers = prover.solve(&problems, limit, stop)?;
    if answers.contains(&Answer::Stopped) {
        return Ok(None);
    }
    let mut result = match &answers[0] {
        // Unit and reference have nothing in common. Were they one circuit before the proof, something is missing.
        Answer::Proved { gates: 0 } if !claim.is_between_likes() => Err(format!("{claim}: the circuit is empty")),
        Answer::Proved { .. } => Ok(()),
        Answer::Refuted(values) => Err(Counterexample::of(prover, &claim, &problems[0], values)?.to_string()),
        Answer::Undecided(why) => Err(format!("{claim}: undecided, {why}")),
        Answer::Stopped => Err(format!("{claim}: stopped")),
    };
    let mut seen = None;
    if let (Some(answer), Some(problem), Some(Some(fault))) = (answers.get(1), problems.get(1), faults.get(1)) {
        match answer {
            Answer::Refuted(values) => {
                let example = Counterexample::of(prover, &claim, problem, values)?;
                example.confirm()?;
                seen = Some(format!("with {} for {}, {example}", fault.to, fault.from));
            }
            other => result = Err(format!("{claim}: a deliberate fault is not seen: {other:?}")),
        }
    }
    Ok(Some(Judged { claim, result, seen }))
}

/// Operands for which a unit does not what the reference does.
struct Counterexample {
    claim: Claim,
    a: u64,
    b: u64,
    ours: u64,
    wanted: u64,
}

impl Counterexample {
    /// Evaluated by Yosys; an error where the sides do not differ.
    fn of(prover: &Prover, claim: &Claim, problem: &Problem, values: &BTreeMap<String, u64>) -> Result<Self, Error> {
        let shown = prover.evaluate(problem, values, &["a", "b", "ours", "wanted", "valid"])?;
        match shown[..] {
            [a, b, ours, wanted, 1] if ours != wanted => Ok(Self { claim: *claim, a, b, ours, wanted }),
            _ => Err(Error::Program {
                program: "abc".to_string(),
                problem: format!("{claim}: a counterexample that is none: {values:x?} gives {shown:x?}"),
                expected: "operands for which the sides differ".to_string(),
            }),
        }
    }

    /// That the unit without the fault, simulated, does here what the reference does.
    fn confirm(&self) -> Result<(), Error> {
        let (format, &Self { a, b, .. }) = (self.claim.format, self);
        let encoded = |value| format.encode(value);
        let top = 1 << (format.recoded_width() - 1);
        let shown = match self.claim.subject {
            Subject::Add => format.decode(simulated(&add(format)?, encoded(a), encoded(b))?[0]),
            Subject::Sub => format.decode(simulated(&add(format)?, encoded(a), encoded(b) ^ top)?[0]),
            Subject::Mul => format.decode(simulated(&mul(format)?, encoded(a), encoded(b))?[0]),
            Subject::Compare => {
                simulated(&compare(format)?, encoded(a), encoded(b))?.into_iter().fold(0, |word, bit| word << 1 | bit)
            }
            Subject::RoundTrip => format.canonical(a),
            Subject::AddParts(_) => simulated(&add(format)?, a, b)?[0],
            Subject::MulParts(_) => simulated(&mul(format)?, a, b)?[0],
        };
        if shown == self.wanted {
            return Ok(());
        }
        Err(Error::Program {
            program: "yosys".to_string(),
            problem: format!("{self}; but the simulator shows {shown:#x}"),
            expected: "the reference and the unit without a fault to agree".to_string(),
        })
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

fn simulated(unit: &std::sync::Arc<raypath_hdl::Module>, a: u64, b: u64) -> Result<Vec<u64>, Error> {
    let mut simulator = Simulator::new(unit)?;
    for (port, value) in unit.inputs().iter().zip([a, b]) {
        let input = simulator.input(&port.name)?;
        simulator.set(input, value);
    }
    simulator.settle();
    unit.outputs().iter().map(|port| Ok(simulator.get(simulator.output(&port.name)?))).collect()
}
