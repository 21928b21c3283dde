//! Each value of each parameter gives another design.
//!
//! Known bug, without a published source: a parameter that is declared and documented but has no effect, so that all
//! points of a sweep are the same. The emitted SystemVerilog would then differ only in its head comment.
//!
//! Mutation: a parameter that is ignored in `raypath-rtl`, for example `sharing` always taken as `Union`.

use raypath::hdl::verilog;
use raypath::ops::Rules;
use raypath::rtl::{
    Config, Control, Datapath, Encoding, Interval, Lanes, Multiplier, Sharing, UnitLatency, UnitSharing,
};
use std::collections::HashMap;

/// The text of all modules without comments, because comments name the configuration.
fn printed(config: Config) -> String {
    let datapath = Datapath::new(config).expect("a datapath");
    let sources = verilog::sources(datapath.top(), &[]).expect("modules");
    let texts = sources.into_iter().map(|source| source.text);
    let text: String = texts.collect();
    let code = text.lines().map(|line| line.split("//").next().unwrap_or_default().trim_end());
    code.filter(|line| !line.is_empty()).collect::<Vec<_>>().join("\n")
}

/// Every value of one parameter, all others as in `base`, differs from every other.
fn all_differ<T: Copy + std::fmt::Display>(base: Config, values: &[T], set: impl Fn(&mut Config, T)) {
    let mut seen: HashMap<String, T> = HashMap::new();
    for &value in values {
        let mut config = base;
        set(&mut config, value);
        if let Some(other) = seen.insert(printed(config), value) {
            panic!("{base}: {value} makes what {other} makes");
        }
    }
    assert!(values.len() > 1);
}

#[test]
fn every_value_of_every_parameter_changes_the_design() {
    let graphics = Config::DEFAULT.lanes(Lanes::None);
    let small = Config::DEFAULT.lanes(Lanes::Two);
    for base in [graphics, small] {
        all_differ(base, &[Rules::Paper, Rules::Chisel], |config, rules| config.semantics.rules = rules);
        all_differ(base, Encoding::ALL, |config, io| config.microarchitecture.io = io);
        all_differ(base, Encoding::ALL, |config, registers| config.microarchitecture.registers = registers);
        all_differ(base, Control::ALL, |config, control| config.microarchitecture.control = control);
        all_differ(base, Sharing::ALL, |config, sharing| config.microarchitecture.sharing = sharing);
        all_differ(base, UnitSharing::ALL, |config, units| config.microarchitecture.units = units);
        all_differ(base, Interval::ALL, |config, interval| config.microarchitecture.interval = interval);
        all_differ(base, UnitLatency::ALL, |config, latency| config.microarchitecture.unit_latency = latency);
        all_differ(base, &[false, true], |config, gated| config.microarchitecture.clock_gating = gated);
        all_differ(base, Multiplier::ALL, |config, multiplier| config.microarchitecture.multiplier = multiplier);
        all_differ(base, &["fp32", "tf32", "bf16", "fp16", "e3s3", "e8s23"], |config, name| {
            config.semantics.format = name.parse().expect("a format");
        });
    }
    all_differ(Config::DEFAULT, Lanes::ALL, |config, lanes| config.semantics.lanes = lanes);
}

/// The comparison ignores comments, and detects two equal designs.
#[test]
fn the_same_configuration_makes_the_same_design() {
    let config = Config::DEFAULT.lanes(Lanes::None);
    assert!(printed(config) == printed(config) && printed(config).contains("endmodule"));
}
