//! The space of configurations that a search goes through.

use super::Arguments;
use crate::CliError;
use raypath_float::Format;
use raypath_ops::Rules;
use raypath_ppa::Library;
use raypath_rtl::{Config, Features, PRESETS, Parameter, Preset, parameters};
use raypath_sim::configuration;
use std::collections::BTreeMap;

/// Configurations with their names, and what is none.
pub struct Space {
    pub members: Vec<(String, Config)>,
    /// Combinations that the configuration refuses: their number by reason.
    pub refused: BTreeMap<String, usize>,
}

/// The values of microarchitecture parameters that are combined around each preset. `io` is not among them, because it
/// changes the ports, and neither is `multiplier`, which is for FPGAs.
const VALUES: [(&str, &[&str]); 7] = [
    ("registers", &["recoded", "ieee"]),
    ("control", &["skid", "credit"]),
    ("sharing", &["union", "segregated"]),
    ("units", &["shared", "disjoint"]),
    ("interval", &["1", "2", "4", "8"]),
    ("unit-latency", &["1", "2", "3", "4", "6", "10/8"]),
    ("clock-gating", &["false", "true"]),
];

/// The bits of boxes that are combined with them where the rules are `paper` and the format is binary32.
const BOX_BITS: [&str; 6] = ["10", "11", "12", "13", "14", "16"];

/// The space of the arguments: the combinations of a sweep, or those around presets. Those that the configuration or
/// the library refuses are counted.
pub fn space(arguments: &Arguments, library: &Library) -> Result<Space, CliError> {
    let all = match &arguments.sweep {
        Some(path) => configuration::sweep(path)?,
        None if arguments.preset.is_empty() => around(&PRESETS[0])?,
        None => arguments.preset.iter().map(around).collect::<Result<Vec<_>, _>>()?.concat(),
    };
    let mut space = Space { members: Vec::new(), refused: BTreeMap::new() };
    for (name, config) in all {
        match config.check() {
            Ok(()) if config.microarchitecture.clock_gating && !library.has_clock_gates() => {
                let reason = format!("clock-gating true: {} has no clock gate", library.name);
                *space.refused.entry(reason).or_default() += 1;
            }
            Ok(()) if space.members.iter().any(|(_, known)| *known == config) => {}
            Ok(()) => space.members.push((name, config)),
            Err(reason) => *space.refused.entry(reason.to_string()).or_default() += 1,
        }
    }
    if space.members.is_empty() {
        let reasons: Vec<&str> = space.refused.keys().map(String::as_str).collect();
        let problem = format!("no configuration to search, expected one at least: {}", reasons.join("; "));
        return Err(CliError::unusable(problem));
    }
    Ok(space)
}

/// All combinations of [`VALUES`] and [`BOX_BITS`] around a preset, the preset first. Their names consist of the preset
/// and what differs from it.
fn around(preset: &Preset) -> Result<Vec<(String, Config)>, CliError> {
    let Config { semantics, .. } = preset.config;
    let mut all = vec![preset.config];
    if semantics.rules == Rules::Paper && semantics.format == Format::BINARY32 && semantics.features == Features::OFF {
        for bits in BOX_BITS {
            all.push(with(with(preset.config, "rules", "bounds")?, "box-bits", bits)?);
        }
    }
    for (name, values) in VALUES {
        // The preset's own value comes first.
        let own = parameter(name)?.get(&preset.config);
        let others = values.iter().copied().filter(|value| *value != own);
        let values: Vec<&str> = [own.as_str()].into_iter().chain(others).collect();
        let combined = all.iter().flat_map(|config| values.iter().map(|value| with(*config, name, value)));
        all = combined.collect::<Result<_, _>>()?;
    }
    let named = |config: Config| {
        let differs = parameters().filter(|parameter| parameter.get(&config) != parameter.get(&preset.config));
        let words = differs.map(|parameter| format!("{}-{}", parameter.name, parameter.get(&config)));
        ([preset.name.to_string()].into_iter().chain(words).collect::<Vec<_>>().join("-"), config)
    };
    Ok(all.into_iter().map(named).collect())
}

fn with(mut config: Config, name: &str, value: &str) -> Result<Config, CliError> {
    parameter(name)?.set(&mut config, value).map_err(CliError::unusable)?;
    Ok(config)
}

fn parameter(name: &str) -> Result<&'static Parameter, CliError> {
    let found = parameters().find(|parameter| parameter.name == name);
    found.ok_or_else(|| CliError::unusable(format!("'{name}' is not a parameter, expected one of a configuration")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Each parameter of the lists is one, and the numbers of combinations are those that are counted by hand: with an
    /// interval of 1 all 2·2·2·2·6·2 combinations, with rules paper and 6 numbers of bits; with 2, 4 or 8 only those
    /// with rules paper, units of one step and without clock gates.
    #[test]
    fn the_space_around_a_preset_is_counted() {
        let all = around(&PRESETS[0]).expect("values of the parameters");
        let valid: Vec<_> = all.iter().filter(|(_, config)| config.check().is_ok()).collect();
        // Intervals with the rules of the preset; with units of several steps they need credits.
        let folded = 3 * 16 + 3 * 8 * 5;
        assert_eq!((all.len(), valid.len()), (7 * 16 * 4 * 6 * 2, 7 * 16 * 6 * 2 + folded));
        assert_eq!(all[0], ("paper".to_string(), Config::DEFAULT));
        let names: BTreeSet<&String> = all.iter().map(|(name, _)| name).collect();
        assert_eq!(names.len(), all.len());
        assert!(names.contains(&"paper-control-credit-interval-2".to_string()));
        let half = PRESETS.iter().find(|preset| preset.name == "half").expect("a preset");
        assert_eq!(around(half).expect("values").len(), 16 * 4 * 6 * 2);
    }
}
