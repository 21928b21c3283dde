//! Theorems about units, each composed of lemmas that SAT proves.

use super::lemma::Lemma;
use super::product::Multiplier;
use super::{certificate_limit, certificates};
use raypath_float::Format;
use raypath_tools::pool;
use raypath_verify::sat::{Certificate, Miter, ProofResult, Prover};
use raypath_verify::{Error, Level, Request, Verdict};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Lemmas for which Yosys starts once.
const BATCH: usize = 6;

/// Lemmas, and what follows from them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Theorem {
    /// The lemmas.
    pub lemmas: Vec<Lemma>,
    /// Whether the theorem follows from them; else why not.
    pub follows: Result<(), String>,
}

/// Proves the level's theorems about multipliers. Shards divide the theorems.
///
/// # Errors
/// A program is missing or fails.
pub fn multiplication(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let multipliers: Vec<Multiplier> = multipliers(request.level).collect();
    let (shard, limit) = (request.shard, Duration::from_secs(request.level.pick(300, 1800, 7200)));
    let parts = request.parts.phase(|| {
        let prover = Prover::with_certificates(certificate_limit(request.level))?;
        let mine = (0..).zip(&multipliers).filter(|(number, _)| shard.takes(*number));
        let theorems: Vec<(u64, Theorem)> =
            mine.map(|(number, multiplier)| Ok((number, multiplier.theorem()?))).collect::<Result<_, Error>>()?;
        let work: Vec<(usize, &[Lemma])> = theorems
            .iter()
            .enumerate()
            .flat_map(|(index, (_, theorem))| theorem.lemmas.chunks(BATCH).map(move |lemmas| (index, lemmas)))
            .collect();
        let name = |index: usize| multipliers[theorems[index].0 as usize].to_string();
        let found = pool::map(&work, pool::ALL_CORES, request.proceed, |&(index, lemmas), stop| {
            prove(&prover, &name(index), lemmas, limit, stop)
        })?;
        let mut part = Part { versions: prover.versions(), theorems: BTreeMap::new() };
        for (number, theorem) in &theorems {
            let failures =
                theorem.follows.as_ref().err().map(|why| format!("{}: {why}", multipliers[*number as usize]));
            let (count, failures) = (theorem.lemmas.len(), failures.into_iter().collect());
            part.theorems.insert(*number, Outcome { count, proved: Vec::new(), failures });
        }
        for ((index, _), proofs) in work.iter().zip(found) {
            let outcome = part.theorems.entry(theorems[*index].0).or_default();
            for proof in proofs.into_iter().flatten() {
                match proof {
                    Ok(remark) => outcome.proved.push(remark),
                    Err(failure) => outcome.failures.push(failure),
                }
            }
        }
        Ok::<_, Error>(part)
    })?;
    Ok(verdict(&multipliers, &parts))
}

/// The name of a lemma, its certificate, and a remark on its fault.
type Proof = (String, Certificate, String);

/// The results of a shard.
#[derive(Serialize, Deserialize)]
struct Part {
    versions: String,
    /// By number.
    theorems: BTreeMap<u64, Outcome>,
}

/// What was found of a theorem.
#[derive(Default, Serialize, Deserialize)]
struct Outcome {
    /// How many lemmas it has.
    count: usize,
    /// For each lemma that is proved and whose fault is refuted, its name, its certificate, and a remark on the fault.
    proved: Vec<Proof>,
    failures: Vec<String>,
}

fn verdict(multipliers: &[Multiplier], parts: &[Part]) -> Verdict {
    let outcomes: BTreeMap<u64, &Outcome> =
        parts.iter().flat_map(|part| part.theorems.iter().map(|(number, outcome)| (*number, outcome))).collect();
    let named = || outcomes.iter().filter_map(|(number, outcome)| Some((multipliers.get(*number as usize)?, *outcome)));
    let is_proved = |outcome: &Outcome| outcome.failures.is_empty() && outcome.proved.len() == outcome.count;
    let proved: Vec<String> = named()
        .filter(|(_, outcome)| is_proved(outcome))
        .map(|(multiplier, outcome)| format!("{multiplier} by {} lemmas", outcome.count))
        .collect();
    let refuted: usize = outcomes.values().map(|outcome| outcome.proved.len()).sum();
    let covered = match proved.len() {
        0 => "nothing proved".to_string(),
        count => format!("{count} theorems, and {refuted} faults refuted: {}", proved.join("; ")),
    };
    let failures = outcomes.values().flat_map(|outcome| outcome.failures.iter().cloned());
    let versions: BTreeSet<&str> = parts.iter().map(|part| part.versions.as_str()).collect();
    let versions = format!("with {}", versions.into_iter().collect::<Vec<_>>().join("; "));
    let proofs = || outcomes.values().flat_map(|outcome| &outcome.proved);
    let certified = certificates(proofs().map(|(name, certificate, _)| (name.as_str(), certificate)));
    let faults = proofs().map(|(.., fault)| fault.clone());
    let is_done = |outcome: &Outcome| outcome.failures.len() + outcome.proved.len() >= outcome.count;
    Verdict {
        covered,
        failures: failures.collect(),
        remarks: [versions, certified].into_iter().chain(faults).collect(),
        is_stopped: !outcomes.values().all(|outcome| is_done(outcome)),
    }
}

/// Proves lemmas and refutes their faults. For each its proof, or what is wrong. None if the run was stopped.
fn prove(
    prover: &Prover,
    theorem: &str,
    lemmas: &[Lemma],
    limit: Duration,
    stop: &AtomicBool,
) -> Result<Option<Vec<Result<Proof, String>>>, Error> {
    let both = lemmas.iter().flat_map(|lemma| [false, true].map(|with_fault| lemma.miter(theorem, with_fault)));
    let miters: Vec<Miter> = both.collect::<Result<_, _>>()?;
    let results = prover.solve(&miters, limit, stop)?;
    if results.contains(&ProofResult::Stopped) {
        return Ok(None);
    }
    let pairs = miters.iter().zip(&results);
    let refuted: Vec<_> = pairs
        .filter_map(|(miter, result)| match result {
            ProofResult::Refuted(values) => Some((miter, values)),
            _ => None,
        })
        .collect();
    prover.confirm(&refuted, "differ")?;
    let judge = |(pair, miters): (&[ProofResult], &[Miter])| match pair {
        [ProofResult::Proved { certificate, .. }, ProofResult::Refuted(values)] => {
            let (name, values) = (miters[0].name.clone(), values_text(values));
            let fault = format!("a deliberate fault is found: {name}, {values}");
            Ok((name, certificate.clone(), fault))
        }
        [ProofResult::Refuted(values), _] => Err(format!("{}: refuted by {}", miters[0].name, values_text(values))),
        [ProofResult::Undecided(why), _] => Err(format!("{}: undecided, {why}", miters[0].name)),
        other => Err(format!("{}: a deliberate fault is not found: {other:?}", miters[0].name)),
    };
    Ok(Some(results.chunks(2).zip(miters.chunks(2)).map(judge).collect()))
}

/// Values of inputs in a message.
fn values_text(values: &BTreeMap<String, u64>) -> String {
    values.iter().map(|(name, value)| format!("{name} {value:#x}")).collect::<Vec<_>>().join(", ")
}

/// The multipliers of a level. Each level includes those of the shorter ones.
fn multipliers(level: Level) -> impl Iterator<Item = Multiplier> {
    /// Level, widths, whether with `*`, the bits of a short factor or 0, and whether with flags.
    const MULTIPLIERS: &[(Level, u32, u32, bool, u32, bool)] = &[
        (Level::Full, 8, 24, false, 0, true),
        (Level::Full, 8, 24, true, 0, true),
        (Level::Regression, 8, 24, false, 0, false),
        (Level::Regression, 8, 24, true, 0, false),
        (Level::Full, 8, 24, false, 8, false),
        (Level::Full, 8, 24, true, 8, false),
        (Level::Full, 8, 24, false, 13, false),
        (Level::Full, 11, 24, false, 0, false),
        (Level::Full, 5, 11, false, 0, true),
        (Level::Full, 5, 11, true, 0, true),
        (Level::Full, 5, 11, false, 0, false),
        (Level::Full, 8, 11, false, 0, true),
        (Level::Full, 8, 11, false, 0, false),
        (Level::Full, 8, 8, false, 0, true),
        (Level::Full, 8, 8, false, 0, false),
        (Level::Full, 7, 17, false, 0, false),
        (Level::Full, 6, 13, false, 0, false),
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
