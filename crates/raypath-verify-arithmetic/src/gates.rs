//! Proofs that the gates of `raypath ppa` compute what the text says: each floating-point unit before and after
//! synthesis, for all operands.

use raypath_float::Format;
use raypath_hdl::Module;
use raypath_ppa::{Bench, DEFAULT_LIBRARY, Design, Library, SynthesisedUnit};
use raypath_rtl::{Config, Datapath, Lanes, UnitLatency};
use raypath_tools::pool::{self, Progress};
use raypath_tools::{OpenSta, Yosys};
use raypath_verify::equivalence::Equivalence;
use raypath_verify::sat::Prover;
use raypath_verify::{Error, Request, Verdict};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// The cache of synthesised units, which `raypath ppa` shares.
const CACHE: &str = "build/ppa-cache";
/// The period for which `raypath ppa` optimises gates by default, in nanoseconds.
const PERIOD: f64 = 12.0;
const FAILURES_SHOWN: usize = 8;

/// A pair of modules to compare, and whether they must be equal.
struct Claim {
    name: String,
    text: Arc<Module>,
    gates: Arc<Module>,
    is_equal: bool,
}

/// The name of a claim, whether it must hold, and what is wrong.
type Proof = (String, bool, Option<String>);

/// The proofs of a part.
#[derive(Serialize, Deserialize)]
struct Part {
    versions: String,
    /// By the number of the claim.
    results: Vec<(u64, Proof)>,
    is_stopped: bool,
}

/// Proves the units of the level's configurations.
///
/// # Errors
/// A program or the library is missing or fails.
pub fn gates(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let (shard, limit) = (request.shard, Duration::from_secs(request.level.pick(300, 1800, 7200)));
    let configs = request.level.pick(&configs()[..1], &configs()[..], &configs()[..]).to_vec();
    let parts = request.parts.phase(|| {
        let prover = Prover::find()?;
        let claims = claims(&configs, request.proceed)?;
        let numbered: Vec<(u64, &Claim)> = (0..).zip(&claims).filter(|(number, _)| shard.takes(*number)).collect();
        let prove = |(_, claim): &(u64, &Claim), stop: &std::sync::atomic::AtomicBool| {
            let results = prover.equivalent(&[(&claim.text, &claim.gates)], limit, stop)?;
            Ok::<_, Error>(results.into_iter().next().filter(|_| !stop.load(std::sync::atomic::Ordering::Relaxed)))
        };
        let found = pool::map(&numbered, pool::ALL_CORES, request.proceed, prove)?;
        let mut part = Part { versions: prover.versions(), results: Vec::new(), is_stopped: false };
        for ((number, claim), found) in numbered.into_iter().zip(found) {
            let wrong = match (found, claim.is_equal) {
                (None, _) => {
                    part.is_stopped = true;
                    continue;
                }
                (Some(Equivalence::Proved), true) | (Some(Equivalence::Different(_)), false) => None,
                (Some(Equivalence::Proved), false) => Some("a changed gate is not found".to_string()),
                (Some(Equivalence::Different(values)), true) => Some(format!("differs for {values:x?}")),
                (Some(Equivalence::Undecided(why)), _) => Some(why),
            };
            part.results.push((number, (claim.name.clone(), claim.is_equal, wrong)));
        }
        Ok::<_, Error>(part)
    })?;
    let results: BTreeMap<u64, Proof> = parts.iter().flat_map(|part| part.results.iter().cloned()).collect();
    let failures = results.values().filter_map(|(name, _, wrong)| Some(format!("{name}: {}", wrong.as_ref()?)));
    let right =
        |equal: bool| results.values().filter(move |(_, is_equal, wrong)| *is_equal == equal && wrong.is_none());
    let proved: Vec<&str> = right(true).map(|(name, ..)| name.as_str()).collect();
    Ok(Verdict {
        covered: format!(
            "{} units proved, and {} changed gates refuted: {}",
            proved.len(),
            right(false).count(),
            proved.join(", ")
        ),
        failures: failures.take(FAILURES_SHOWN).collect(),
        remarks: parts.first().map(|part| format!("with {}", part.versions)).into_iter().collect(),
        is_stopped: parts.iter().any(|part| part.is_stopped),
    })
}

/// The configurations whose units are proved; the first at every level.
fn configs() -> [Config; 4] {
    let graphics = Config::DEFAULT.lanes(Lanes::None);
    [
        graphics.format(Format::BINARY16),
        graphics,
        graphics.unit_latency(UnitLatency::Two),
        graphics.unit_latency(UnitLatency::Three),
    ]
}

/// For each unit a claim that its gates are equal, and claims that two changed gates are not: the first and the last of
/// those at its output ports, whose inversion shows in every case.
fn claims(configs: &[Config], proceed: &mut dyn FnMut(Progress) -> bool) -> Result<Vec<Claim>, Error> {
    let bench = Bench {
        library: Library::read(Path::new(DEFAULT_LIBRARY)).map_err(Error::subject)?,
        yosys: Yosys::find(None)?,
        sta: OpenSta::find()?,
        period: PERIOD,
        unit_period: None,
        jobs: pool::ALL_CORES,
        cache: CACHE.into(),
    };
    let mut units: BTreeMap<String, SynthesisedUnit> = BTreeMap::new();
    for config in configs {
        let design = Design::new(config.to_string(), Datapath::new(*config)?.top());
        units.extend(
            bench
                .units(&design, proceed)
                .map_err(Error::subject)?
                .into_iter()
                .map(|unit| (unit.unit.name().to_string(), unit)),
        );
    }
    let mut claims = Vec::new();
    for (name, unit) in units {
        let at_ports = unit.at_ports();
        let changed = [at_ports.first(), at_ports.last()].into_iter().flatten().map(|gate| Some(*gate));
        for change in std::iter::once(None).chain(changed) {
            let name = change.map_or(name.clone(), |gate| format!("{name} with gate {gate} inverted"));
            let (text, gates) = (unit.unit.clone(), unit.module(change).map_err(Error::subject)?);
            claims.push(Claim { name, text, gates, is_equal: change.is_none() });
        }
    }
    Ok(claims)
}
