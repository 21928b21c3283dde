//! The table of parameters against the configuration.

use raypath_float::Format;
use raypath_ops::{BoxBits, EdgeRule, Rounding, Rules};
use raypath_rtl::{Config, Control, DatapathNetlist, EXCEPTIONS, Interval, Lanes, Multiplier, UnitLatency, parameters};
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

/// For each exception, a configuration whose only fault it is, and the beginning and the end of the message.
#[test]
fn each_exception_is_refused() {
    let (folded, sums) = (Config::DEFAULT.interval(Interval::Four), Config::DEFAULT.rounding(Rounding::Sum));
    let (bounds, divided, dsp) = (Rules::Bounds(BoxBits::DEFAULT), UnitLatency::TWO, Multiplier::Dsp);
    let delayed = Config::DEFAULT.control(Control::Credit).delay_lines(4);
    let (once, quantised) = (Config::DEFAULT.edges(EdgeRule::Once), Config::DEFAULT.quantised_boxes(true));
    let refused = [
        (Config::DEFAULT.box_bits(BoxBits(9)), "box-bits: 9 is not available with rules paper", "rules bounds"),
        (
            Config::DEFAULT.rules(bounds).format(Format::BINARY16),
            "box-bits: 13 is not available with format fp16",
            "fewer box-bits or a longer format",
        ),
        (
            quantised.conservative(true),
            "quantised-boxes: true is not available with conservative true",
            "conservative false",
        ),
        (once.rules(Rules::Chisel), "edges: once is not available with rules chisel", "rules paper or bounds"),
        (once.exception_flags(true), "edges: once is not available with exception-flags true", "edges shared"),
        (once.interval(Interval::Four), "edges: once is not available with interval 4", "interval 1"),
        (once.unit_latency(divided), "edges: once is not available with unit-latency 2", "unit-latency 1"),
        (quantised.rules(Rules::Chisel), "quantised-boxes: true is not available with rules chisel", "rules paper"),
        (quantised.rules(bounds), "quantised-boxes: true is not available with rules bounds", "rules paper"),
        (
            Config::DEFAULT.exception_flags(true).format(Format::BINARY16),
            "exception-flags: true is not available with format fp16",
            "format fp32",
        ),
        (sums.rules(Rules::Chisel), "rounding: sum is not available with rules chisel", "rules paper or bounds"),
        (sums.interval(Interval::Four), "rounding: sum is not available with interval 4", "interval 1"),
        (sums.unit_latency(divided), "rounding: sum is not available with unit-latency 2", "unit-latency 1"),
        (sums.exception_flags(true), "rounding: sum is not available with exception-flags true", "rounding unit"),
        (Config::DEFAULT.delay_lines(4), "delay-lines: 4 is not available with control skid", "control credit"),
        (delayed.clock_gating(true), "delay-lines: 4 is not available with clock-gating true", "clock-gating false"),
        (delayed.interval(Interval::Four), "delay-lines: 4 is not available with interval 4", "interval 1"),
        (folded.unit_latency(divided), "unit-latency: 2 is not available with control skid", "control credit"),
        (Config::DEFAULT.multiplier(dsp), "multiplier: dsp is not available with control skid", "control credit"),
        (
            Config::DEFAULT.control(Control::Credit).multiplier(dsp).clock_gating(true),
            "multiplier: dsp is not available with clock-gating true",
            "clock-gating false",
        ),
        (
            Config::DEFAULT.control(Control::Credit).multiplier(dsp).unit_latency(divided),
            "multiplier: dsp is not available with unit-latency 2",
            "unit-latency 3 or more",
        ),
        (folded.exception_flags(true), "interval: 4 is not available with exception-flags true", "interval 1"),
        (folded.clock_gating(true), "interval: 4 is not available with clock-gating true", "interval 1"),
        (folded.rules(bounds), "interval: 4 is not available with rules bounds", "interval 1"),
    ];
    assert_eq!(refused.len(), EXCEPTIONS.len());
    for ((config, beginning, expected), exception) in refused.into_iter().zip(EXCEPTIONS) {
        let problem = config.check().expect_err("a refusal").to_string();
        assert_eq!(problem, format!("{beginning}, because {}; expected {expected}", exception.reason));
        assert!(DatapathNetlist::new(config).is_err());
    }
}
