//! Covering arrays: few configurations in which every permitted pair of values of two parameters occurs.
//!
//! A fault that needs certain values of one or two parameters shows in one of them; in practice most faults need no
//! more (Kuhn, Wallace, Gallo 2004). The search is greedy, one configuration after another (Cohen et al. 1997): each
//! begins with a pair that is still missing and takes, for one parameter after another, the value that adds the most.

use raypath_rtl::{Config, PRESETS, Parameter, parameters};
use raypath_tools::ToolError;
use raypath_verify::Error;
use std::collections::BTreeSet;

/// The values that stand for those of parameters with many: the default first, the least, the greatest.
const REPRESENTATIVES: [(&str, &[&str]); 5] = [
    ("format", &["fp32", "fp16", "bf16", "e11s24"]),
    ("box-bits", &["13", "8", "24"]),
    ("unit-latency", &["1", "2", "10/7"]),
    ("delay-lines", &["0", "3"]),
    ("tag", &["0", "1", "32"]),
];

/// The values of all parameters, and the combinations that are permitted: those that [`Config::check`] accepts, and a
/// predicate of the caller. The first values together must be permitted.
pub struct Space<'p> {
    factors: Vec<(&'static Parameter, Vec<&'p str>)>,
    permits: &'p dyn Fn(Config) -> bool,
}

/// A value: the positions of the parameter and of the value.
type Value = (usize, usize);

impl<'p> Space<'p> {
    /// All values, the default first, or a few that stand for many. `permits` excludes configurations.
    pub fn new(permits: &'p dyn Fn(Config) -> bool) -> Self {
        let factors = parameters().map(|parameter| (parameter, values(parameter))).collect();
        Self { factors, permits }
    }

    /// This space with other values of the parameter of this name.
    ///
    /// # Errors
    /// No parameter of this name, or a text that is none of its values.
    pub fn with(mut self, name: &str, values: &[&'p str]) -> Result<Self, Error> {
        let unexpected =
            |found: &str| ToolError::unexpected("raypath", found.to_string(), "a parameter and its values");
        let (parameter, own) =
            self.factors.iter_mut().find(|(parameter, _)| parameter.name == name).ok_or_else(|| unexpected(name))?;
        let mut config = Config::DEFAULT;
        for value in values {
            parameter.set(&mut config, value).map_err(|problem| unexpected(&problem))?;
        }
        *own = values.to_vec();
        Ok(self)
    }

    /// Configurations in which every permitted pair occurs. The same space has always the same ones.
    pub fn covering(&self) -> Vec<Config> {
        let mut missing: BTreeSet<[Value; 2]> = BTreeSet::new();
        for (first, (_, values)) in self.factors.iter().enumerate() {
            for (second, (_, others)) in self.factors.iter().enumerate().skip(first + 1) {
                let pairs = (0..values.len()).flat_map(|a| (0..others.len()).map(move |b| [(first, a), (second, b)]));
                missing.extend(pairs);
            }
        }
        let mut configs = Vec::new();
        while let Some(&pair) = missing.first() {
            let Some(mut row) = self.completed(pair) else {
                missing.remove(&pair);
                continue;
            };
            self.improve(&mut row, pair, &missing);
            for (factor, &value) in row.iter().enumerate() {
                pairs_of(&row, (factor, value)).for_each(|pair| _ = missing.remove(&pair));
            }
            configs.push(self.config(&row));
        }
        configs
    }

    /// The first values, with this pair and the other values that it needs; none if it is refused.
    fn completed(&self, pair: [Value; 2]) -> Option<Vec<usize>> {
        let others = self.needed(pair).or_else(|| {
            // What each of them needs.
            let [first, second] = pair.map(|value| self.needed([value; 2]));
            Some([first?, second?].concat()).filter(|others| self.is_permitted(self.config(&self.row(others, pair))))
        });
        Some(self.row(&others?, pair))
    }

    /// At most two values that a pair needs, if these suffice.
    fn needed(&self, pair: [Value; 2]) -> Option<Vec<Value>> {
        let each =
            || (0..).zip(&self.factors).flat_map(|(factor, (_, all))| (0..all.len()).map(move |at| (factor, at)));
        let two =
            each().flat_map(|first| each().filter(move |second| first <= *second).map(move |second| [first, second]));
        let base = self.config(&self.row(&[], pair));
        // The pair alone comes first.
        let found = std::iter::once(pair).chain(two).find(|values| {
            let mut config = base;
            values.iter().chain(&pair).for_each(|&value| self.set(&mut config, value));
            self.is_permitted(config)
        });
        found.map(Vec::from)
    }

    /// The first values, but these and the pair.
    fn row(&self, values: &[Value], pair: [Value; 2]) -> Vec<usize> {
        let mut row = vec![0; self.factors.len()];
        values.iter().chain(&pair).for_each(|&(factor, value)| row[factor] = value);
        row
    }

    /// Gives each parameter but those of the pair the value that adds the most missing pairs, twice, because the values
    /// that are permitted depend on other parameters.
    fn improve(&self, row: &mut [usize], pair: [Value; 2], missing: &BTreeSet<[Value; 2]>) {
        let mut config = self.config(row);
        for factor in
            (0..2).flat_map(|_| 0..self.factors.len()).filter(|factor| pair.iter().all(|(fixed, _)| fixed != factor))
        {
            let gain = |row: &[usize], value| pairs_of(row, (factor, value)).filter(|it| missing.contains(it)).count();
            let mut best = (gain(row, row[factor]), row[factor]);
            for value in 0..self.factors[factor].1.len() {
                let mut changed = config;
                self.set(&mut changed, (factor, value));
                let found = gain(row, value);
                if found > best.0 && self.is_permitted(changed) {
                    best = (found, value);
                }
            }
            row[factor] = best.1;
            self.set(&mut config, (factor, best.1));
        }
    }

    fn is_permitted(&self, config: Config) -> bool {
        config.check().is_ok() && (self.permits)(config)
    }

    fn config(&self, row: &[usize]) -> Config {
        let mut config = Config::DEFAULT;
        row.iter().enumerate().for_each(|(factor, &value)| self.set(&mut config, (factor, value)));
        config
    }

    /// Sets a value, which is one of the parameter's.
    fn set(&self, config: &mut Config, (factor, value): Value) {
        let (parameter, values) = &self.factors[factor];
        let _ = parameter.set(config, values[value]);
    }
}

/// The presets, and configurations in which every pair of values that is permitted occurs.
pub fn presets_and_pairs(space: &Space<'_>) -> Vec<Config> {
    let mut configs: Vec<Config> = PRESETS.iter().map(|preset| preset.config).collect();
    configs.extend(space.covering());
    let mut known = Vec::new();
    configs.retain(|config| {
        !known.contains(config) && {
            known.push(*config);
            true
        }
    });
    configs
}

/// The pairs of a value with the others of a row.
fn pairs_of(row: &[usize], (factor, value): Value) -> impl Iterator<Item = [Value; 2]> {
    let others = row.iter().copied().enumerate().filter(move |(other, _)| *other != factor);
    others.map(move |other| if other.0 < factor { [other, (factor, value)] } else { [(factor, value), other] })
}

fn values(parameter: &'static Parameter) -> Vec<&'static str> {
    let found = REPRESENTATIVES.iter().find(|(name, _)| *name == parameter.name);
    let mut values = found.map_or_else(|| parameter.values.split('|').collect(), |(_, values)| values.to_vec());
    let default = parameter.default();
    values.sort_by_key(|value| *value != default);
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use raypath_rtl::Lanes;
    use std::collections::BTreeMap;

    /// The parameters that [`Config::check`] reads.
    const LIMITED: [&str; 14] = [
        "rules",
        "box-bits",
        "format",
        "rounding",
        "control",
        "interval",
        "unit-latency",
        "multiplier",
        "delay-lines",
        "clock-gating",
        "edges",
        "conservative",
        "quantised-boxes",
        "exception-flags",
    ];

    type Pair = [(&'static str, String); 2];

    fn pairs(config: &Config, found: &mut BTreeSet<Pair>) {
        let values: Vec<(&str, String)> = parameters().map(|it| (it.name, it.get(config))).collect();
        for (at, first) in values.iter().enumerate() {
            found.extend(values[at + 1..].iter().map(|second| [first.clone(), second.clone()]));
        }
    }

    /// All combinations of the parameters of these names with the others at their default.
    fn product(names: &[&str]) -> Vec<Config> {
        let mut all = vec![Config::DEFAULT];
        for parameter in parameters().filter(|parameter| names.contains(&parameter.name)) {
            let with = |config: &Config, text: &str| {
                let mut config = *config;
                parameter.set(&mut config, text).expect("a value");
                config
            };
            all = all.iter().flat_map(|it| values(parameter).into_iter().map(move |text| with(it, text))).collect();
        }
        all
    }

    /// By brute force: all combinations of the parameters with limits, and of every two parameters one of which has
    /// none. The covering array has exactly the pairs that are permitted among these.
    #[test]
    fn every_permitted_pair_occurs() {
        let mut permitted = BTreeSet::new();
        let limited: Vec<Config> = product(&LIMITED).into_iter().filter(|config| config.check().is_ok()).collect();
        limited.iter().for_each(|config| pairs(config, &mut permitted));
        // A value that needs others, with each value of a parameter without limits.
        let mut examples: BTreeMap<(&str, String), Config> = BTreeMap::new();
        for config in &limited {
            let own = parameters().map(|parameter| ((parameter.name, parameter.get(config)), *config));
            own.for_each(|(value, config)| _ = examples.entry(value).or_insert(config));
        }
        let free: Vec<&Parameter> = parameters().filter(|it| !LIMITED.contains(&it.name)).collect();
        for (parameter, value) in free.iter().flat_map(|it| values(it).into_iter().map(move |value| (*it, value))) {
            for example in examples.values() {
                let mut config = *example;
                parameter.set(&mut config, value).expect("a value");
                assert!(config.check().is_ok(), "{config}");
                pairs(&config, &mut permitted);
            }
            for (other, second) in free.iter().flat_map(|it| values(it).into_iter().map(move |value| (*it, value))) {
                let mut config = Config::DEFAULT;
                parameter.set(&mut config, value).expect("a value");
                other.set(&mut config, second).expect("a value");
                pairs(&config, &mut permitted);
            }
        }
        let configs = Space::new(&|_| true).covering();
        let mut found = BTreeSet::new();
        configs.iter().for_each(|config| pairs(config, &mut found));
        let lacking: Vec<&Pair> = permitted.difference(&found).collect();
        assert!(lacking.is_empty(), "{} pairs, such as {:?}", lacking.len(), lacking.first());
        assert!(configs.iter().all(|config| config.check().is_ok()));
        assert!((35..=60).contains(&configs.len()), "{}", configs.len());
    }

    #[test]
    fn a_space_has_the_values_and_combinations_of_its_caller() {
        let permits = |config: Config| config.semantics.lanes != Lanes::Four || config.semantics.features.tag == 0;
        let space = Space::new(&permits).with("lanes", &["2", "4"]).and_then(|space| space.with("format", &["e4s5"]));
        let space = space.expect("values");
        assert!(Space::new(&permits).with("lanes", &["3"]).is_err());
        let configs = space.covering();
        assert!(configs.iter().all(|config| permits(*config)));
        let with = |lanes| configs.iter().filter(move |config| config.semantics.lanes == lanes).count();
        assert!(with(Lanes::Two) > 0 && with(Lanes::Four) > 0 && with(Lanes::Two) + with(Lanes::Four) == configs.len());
        assert!(configs.iter().all(|config| config.semantics.format.name() == "e4s5"));
    }
}
