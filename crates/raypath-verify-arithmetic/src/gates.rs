//! Proofs that the gates of `raypath ppa` compute what the text says: each floating-point unit before and after
//! synthesis, for all operands.

use crate::units::proofs::{Proof, prove};
use raypath_float::Format;
use raypath_ppa::{Bench, DEFAULT_LIBRARY, Design, Library, SynthesisedUnit};
use raypath_rtl::{Config, DatapathNetlist, Lanes, UnitLatency};
use raypath_tools::{OpenSta, Yosys};
use raypath_verify::equivalence::miter;
use raypath_verify::{Error, Request, Verdict};
use raypath_work::pool::{self, Progress};
use std::collections::BTreeMap;
use std::path::Path;

/// The cache of synthesised units, which `raypath ppa` shares.
const CACHE: &str = "build/ppa-cache";
/// The period for which `raypath ppa` optimises gates by default, in nanoseconds.
const PERIOD: f64 = 12.0;

/// Proves the units of the level's configurations, and refutes two changed gates of each: the first and the last of
/// those at its output ports, whose inversion shows in every case.
///
/// # Errors
/// A program or the library is missing or fails.
pub fn gates(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let configs = configs();
    let configs = request.level.pick(&configs[..1], &configs[..], &configs[..]);
    prove(request, 1, |proceed| {
        let mut proofs = Vec::new();
        for (name, unit) in units(configs, proceed)? {
            let at_ports = unit.at_ports();
            let with = |change| miter(&unit.unit, &unit.module(change).map_err(Error::subject)?);
            let changed = [at_ports.first(), at_ports.last()].into_iter().flatten();
            let faults = changed.map(|gate| with(Some(*gate))).collect::<Result<_, Error>>()?;
            proofs.push(Proof { subject: name, claim: with(None)?, faults, is_alike: true });
        }
        Ok(proofs)
    })
}

/// The configurations whose units are proved; the first at every level.
fn configs() -> [Config; 4] {
    let graphics = Config::DEFAULT.lanes(Lanes::None);
    [
        graphics.format(Format::BINARY16),
        graphics,
        graphics.unit_latency(UnitLatency::TWO),
        graphics.unit_latency(UnitLatency::THREE),
    ]
}

/// The synthesised units of configurations, by name.
fn units(
    configs: &[Config],
    proceed: &mut dyn FnMut(Progress) -> bool,
) -> Result<BTreeMap<String, SynthesisedUnit>, Error> {
    let bench = Bench {
        library: Library::read(Path::new(DEFAULT_LIBRARY)).map_err(Error::subject)?,
        yosys: Yosys::find(None)?,
        sta: OpenSta::find()?,
        period: PERIOD,
        unit_period: None,
        jobs: pool::ALL_CORES,
        cache: CACHE.into(),
    };
    let mut units = BTreeMap::new();
    for config in configs {
        let design = Design::new(config.to_string(), DatapathNetlist::new(*config)?.top());
        let found = bench.units(&design, proceed).map_err(Error::subject)?;
        units.extend(found.into_iter().map(|unit| (unit.unit.name().to_string(), unit)));
    }
    Ok(units)
}
