//! The table of parameters against the configuration.

use raypath_ops::{BoxBits, Rules};
use raypath_rtl::{Config, Datapath, Interval, Lanes, UnitLatency, parameters};
use std::collections::BTreeSet;

/// Every listed value of a parameter is accepted, selects a configuration of its own, and is displayed unchanged.
#[test]
fn every_value_is_accepted_and_shown() {
    for parameter in parameters() {
        let mut seen = Vec::new();
        let default = parameter.get(&Config::DEFAULT);
        let mut values: BTreeSet<&str> = parameter.values.split(['|', '.']).filter(|text| !text.is_empty()).collect();
        // The default is inside a range.
        values.insert(&default);
        for text in values {
            let text = if text == "eXsY" { "e3s5" } else { text };
            let mut config = Config::DEFAULT;
            parameter.set(&mut config, text).unwrap_or_else(|problem| panic!("{}: {problem}", parameter.name));
            assert_eq!(parameter.get(&config), text, "{}", parameter.name);
            assert!(!seen.contains(&config), "{} {text}", parameter.name);
            seen.push(config);
        }
        assert!(seen.contains(&Config::DEFAULT) && seen.len() > 1, "{}", parameter.name);
        let problem = parameter.set(&mut Config::DEFAULT.clone(), "nonsense").expect_err(parameter.name);
        assert!(problem.starts_with("'nonsense'") && problem.contains("expected"), "{problem}");
    }
}

#[test]
fn each_parameter_has_a_name_and_a_help_text_of_its_own() {
    let names: BTreeSet<&str> = parameters().map(|parameter| parameter.name).collect();
    let helps: BTreeSet<String> = parameters().map(|parameter| parameter.help()).collect();
    let count = parameters().count();
    assert_eq!((names.len(), helps.len()), (count, count));
    assert!(helps.iter().all(|help| !help.is_empty() && !help.ends_with('.')), "{helps:?}");
}

#[test]
fn the_display_of_a_configuration_is_its_changes() {
    let config = Config::DEFAULT.lanes(Lanes::Two).tag(4).facing(true);
    assert_eq!(config.to_string(), "lanes 2, rules paper, tag 4, facing true");
    assert_eq!(config.options(), "--lanes 2 --tag 4 --facing");
    assert_eq!(Config::DEFAULT.to_string(), "lanes 16, rules paper");
}

/// The message names the option, its value and what was expected.
#[test]
fn an_interval_is_refused_where_it_cannot_work() {
    let folded = Config::DEFAULT.interval(Interval::Four);
    for (config, expected) in [
        (
            folded.unit_latency(UnitLatency::Two),
            "interval: 4 is not available with unit-latency 2, expected unit-latency 1",
        ),
        (folded.exception_flags(true), "interval: 4 is not available with exception flags, expected interval 1"),
        (folded.clock_gating(true), "interval: 4 is not available with clock gating, expected interval 1"),
        (
            folded.rules(Rules::Bounds(BoxBits::DEFAULT)),
            "interval: 4 is not available with rules bounds, expected interval 1",
        ),
    ] {
        let problem = Datapath::new(config).expect_err("a refusal");
        assert_eq!(problem.to_string(), expected);
    }
}
