//! Configurations: the netlist equals the cycle-exact model in every cycle, every outcome equals that of the functional
//! model, and latency and throughput are as documented.

use rayon::prelude::*;
use raypath_float::Format;
use raypath_ops::{BoxBits, Culling, Rounding, Rules};
use raypath_rtl::{
    Accumulators, Config, Control, Encoding, Features, Interval, Lanes, Multiplier, Sharing, UnitLatency, UnitSharing,
};
use raypath_sim::Datapath;
use raypath_sim::engine::NetlistEngine;
use raypath_sim::lockstep::{CONFIGS, RegressionChecks};

/// A set of configurations: all combinations of these values.
struct Space {
    rules: &'static [Rules],
    lanes: &'static [Lanes],
    formats: &'static [&'static str],
    io: &'static [Encoding],
    registers: &'static [Encoding],
    control: &'static [Control],
    sharing: &'static [Sharing],
    unit_latency: &'static [UnitLatency],
    units: &'static [UnitSharing],
    interval: &'static [Interval],
    clock_gating: &'static [bool],
    multiplier: &'static [Multiplier],
}

/// Only the default configuration.
const DEFAULT: Space = Space {
    rules: &[Rules::Paper],
    lanes: &[Lanes::Sixteen],
    formats: &["fp32"],
    io: &[Encoding::Ieee],
    registers: &[Encoding::Recoded],
    control: &[Control::Skid],
    sharing: &[Sharing::Union],
    unit_latency: &[UnitLatency::One],
    units: &[UnitSharing::Shared],
    interval: &[Interval::One],
    clock_gating: &[false],
    multiplier: &[Multiplier::Booth],
};

const RULES: &[Rules] = &[Rules::Paper, Rules::Chisel];
const FEW_AND_MANY_LANES: &[Lanes] = &[Lanes::None, Lanes::Two, Lanes::Sixteen, Lanes::SixtyFour];

/// The configurations into which `raypath verify mutation` inserts faults, with as many jobs as it runs.
#[test]
fn configurations_of_mutation_testing() {
    for config in CONFIGS {
        check(config, 1, RegressionChecks::THOROUGH);
    }
}

#[test]
fn configurations_of_all_spaces() {
    let all = distinct(SPACES.iter().flat_map(Space::configs));
    all.par_iter().enumerate().for_each(|(seed, config)| check(*config, seed as u64, 2000));
}

const SPACES: [Space; 14] = [
    LANES_AND_RULES,
    ENCODINGS,
    CONTROL_WITHOUT_DISTANCES,
    CONTROL_WITH_DISTANCES,
    ENCODINGS_WITH_CONTROL,
    FORMATS,
    FORMATS_WITH_CONTROL,
    UNITS,
    FOLDED,
    FOLDED_REGISTERS,
    FOLDED_ENCODINGS,
    FOLDED_FORMATS,
    CLOCK_GATES,
    INFERRED_MULTIPLIERS,
];

const LANES_AND_RULES: Space = Space { lanes: Lanes::ALL, rules: RULES, ..DEFAULT };

/// Table VI, complete: 28 configurations.
const ENCODINGS: Space = Space { io: Encoding::ALL, registers: Encoding::ALL, lanes: Lanes::ALL, ..DEFAULT };

const CONTROL: Space =
    Space { control: Control::ALL, sharing: Sharing::ALL, unit_latency: UnitLatency::ALL, ..DEFAULT };
const CONTROL_WITHOUT_DISTANCES: Space = Space { rules: RULES, lanes: &[Lanes::None], ..CONTROL };
const CONTROL_WITH_DISTANCES: Space = Space { lanes: &[Lanes::Two, Lanes::Sixteen, Lanes::SixtyFour], ..CONTROL };

/// Encodings with all parameters that change the registers.
const ENCODINGS_WITH_CONTROL: Space =
    Space { lanes: &[Lanes::Four], registers: &[Encoding::Ieee], io: Encoding::ALL, ..CONTROL };

/// Formats from the smallest to the largest.
const FORMATS: Space = Space {
    formats: &["tf32", "bf16", "fp16", "e3s3", "e4s4", "e5s3", "e11s24"],
    io: Encoding::ALL,
    registers: Encoding::ALL,
    ..DEFAULT
};

const FORMATS_WITH_CONTROL: Space = Space {
    formats: &["bf16", "e3s3"],
    lanes: FEW_AND_MANY_LANES,
    control: Control::ALL,
    unit_latency: UnitLatency::ALL,
    ..DEFAULT
};

/// Units of each operation, with units of one and of several steps.
const UNITS: Space = Space {
    lanes: &[Lanes::None, Lanes::Four],
    unit_latency: UnitLatency::ALL,
    units: &[UnitSharing::Disjoint],
    ..DEFAULT
};

const INTERVALS: &[Interval] = &[Interval::Two, Interval::Four, Interval::Eight];
const FOLDED: Space =
    Space { rules: RULES, lanes: FEW_AND_MANY_LANES, control: Control::ALL, interval: INTERVALS, ..DEFAULT };

const FOLDED_REGISTERS: Space = Space {
    lanes: &[Lanes::None, Lanes::Four],
    control: Control::ALL,
    sharing: &[Sharing::Segregated],
    units: UnitSharing::ALL,
    interval: INTERVALS,
    ..DEFAULT
};

const FOLDED_ENCODINGS: Space = Space {
    lanes: &[Lanes::Two],
    io: Encoding::ALL,
    registers: Encoding::ALL,
    control: Control::ALL,
    interval: &[Interval::Four],
    ..DEFAULT
};

const FOLDED_FORMATS: Space =
    Space { formats: &["bf16", "e3s3"], lanes: &[Lanes::None, Lanes::Two], interval: INTERVALS, ..DEFAULT };

/// Clock gates with all parameters that change the registers and their enables.
const CLOCK_GATES: Space = Space { lanes: &[Lanes::None, Lanes::Two], clock_gating: &[true], ..CONTROL };

/// Multipliers with `*` in one, two and three parts.
const INFERRED_MULTIPLIERS: Space = Space {
    formats: &["fp32", "e3s3"],
    lanes: &[Lanes::None, Lanes::Two],
    control: Control::ALL,
    unit_latency: UnitLatency::ALL,
    multiplier: &[Multiplier::Inferred],
    ..DEFAULT
};

/// Boxes in few bits: every width, and some with each parameter that changes units or registers.
#[test]
fn boxes_in_few_bits() {
    let bounds = |bits: u32| Config::DEFAULT.rules(Rules::Bounds(BoxBits::DEFAULT)).box_bits(BoxBits(bits));
    let widths = (8..=24).map(|bits| bounds(bits).lanes(Lanes::None).control(Control::Credit));
    let mut configs: Vec<Config> = widths.collect();
    for bits in [9, 12, 13] {
        configs.extend(UnitLatency::ALL.iter().map(|&latency| bounds(bits).unit_latency(latency)));
        configs.push(bounds(bits).io(Encoding::Recoded).registers(Encoding::Ieee));
        configs.push(bounds(bits).sharing(Sharing::Segregated).lanes(Lanes::Two));
    }
    for (format, bits) in [("tf32", 11), ("bf16", 8), ("fp16", 10), ("e11s24", 13)] {
        configs.push(bounds(bits).format(format.parse().expect("a format")));
    }
    let features = Features { exception_flags: true, range: true, ..Features::OFF };
    configs.push(bounds(13).features(features));
    configs.par_iter().enumerate().for_each(|(seed, config)| check(*config, seed as u64, 2000));
}

/// Sums that round once, with every number of lanes and each parameter that changes units, registers or operations.
#[test]
fn sums_that_round_once() {
    let sum = Config::DEFAULT.rounding(Rounding::Sum);
    let mut configs: Vec<Config> = Lanes::ALL.iter().map(|&lanes| sum.lanes(lanes)).collect();
    configs.extend(Lanes::ALL.iter().map(|&lanes| sum.lanes(lanes).control(Control::Credit)));
    for lanes in [Lanes::None, Lanes::Four, Lanes::Sixteen] {
        let sum = sum.lanes(lanes);
        configs.extend([
            sum.sharing(Sharing::Segregated),
            sum.units(UnitSharing::Disjoint),
            sum.registers(Encoding::Ieee),
            sum.io(Encoding::Recoded),
            sum.clock_gating(true),
            sum.multiplier(Multiplier::Inferred).control(Control::Credit),
            sum.rules(Rules::Bounds(BoxBits::DEFAULT)),
            sum.features(Features { accumulators: Accumulators::Four, ..Features::OFF }),
            sum.features(Features { conservative: true, tag: 8, ..Features::OFF }),
            sum.features(Features { barycentrics: true, facing: true, culling: Culling::None, ..Features::OFF }),
            sum.features(Features { range: true, culling: Culling::Front, ..Features::OFF }),
        ]);
        for format in ["tf32", "bf16", "fp16", "e3s3", "e4s4", "e11s24"] {
            configs.push(sum.format(format.parse().expect("a format")));
        }
    }
    assert_eq!(configs.len(), 65);
    configs.par_iter().enumerate().for_each(|(seed, config)| check(*config, seed as u64, 2000));
}

/// Sums that round once shorten the pipeline, unless an operation computes something in the stages that they save.
#[test]
fn sums_that_round_once_shorten_the_pipeline() {
    let latency = |config: Config| Datapath::paper(config).elaborate().expect("a datapath").latency();
    let sum = Config::DEFAULT.rounding(Rounding::Sum);
    assert_eq!(
        [Config::DEFAULT, sum, sum.lanes(Lanes::SixtyFour), sum.lanes(Lanes::None)].map(latency),
        [12, 10, 10, 10]
    );
    assert_eq!(latency(sum.features(Features { range: true, ..Features::OFF })), 12);
}

#[test]
fn sums_that_round_once_are_refused_where_they_do_not_exist() {
    let sum = Config::DEFAULT.rounding(Rounding::Sum);
    let refused = [
        (sum.rules(Rules::Chisel), "expected rules paper or bounds"),
        (sum.interval(Interval::Two), "expected interval 1"),
        (sum.unit_latency(UnitLatency::Two), "expected unit-latency 1"),
        (sum.features(Features { exception_flags: true, ..Features::OFF }), "expected rounding unit"),
    ];
    for (config, reason) in refused {
        let error = config.check().expect_err("a refused configuration").to_string();
        assert!(error.starts_with("rounding: sum is not available") && error.ends_with(reason), "{config}: {error}");
    }
}

/// The page on configurations states how many configurations these tests run.
#[test]
fn documents_state_the_number_of_configurations() {
    let run = distinct(CONFIGS.into_iter().chain(SPACES.iter().flat_map(Space::configs)));
    let (binary32, others): (Vec<Config>, Vec<Config>) =
        run.into_iter().partition(|config| config.semantics.format == Format::BINARY32);
    let mut formats: Vec<Format> = others.iter().map(|config| config.semantics.format).collect();
    formats.sort_by_key(|format| format.to_string());
    formats.dedup();
    let gated = &[false, true];
    let all = Space {
        clock_gating: gated,
        rules: RULES,
        lanes: Lanes::ALL,
        io: Encoding::ALL,
        registers: Encoding::ALL,
        units: UnitSharing::ALL,
        interval: Interval::ALL,
        multiplier: Multiplier::ALL,
        ..CONTROL
    };
    let valid = all.configs().into_iter().filter(|config| config.check().is_ok()).count();
    let sentence = format!(
        "The tests compare the netlist with the cycle-exact and the functional model under random handshakes in {} \
         configurations: {} of the {} combinations in `fp32`, and {} in {} other formats",
        binary32.len() + others.len(),
        binary32.len(),
        valid,
        others.len(),
        formats.len(),
    );
    let page = include_str!("../../../docs/reference/configurations.md");
    let page = page.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(page.contains(&sentence), "docs/reference/configurations.md should say: {sentence}");
}

impl Space {
    fn configs(&self) -> Vec<Config> {
        let mut configs = vec![Config::DEFAULT];
        vary(&mut configs, self.lanes, |config, lanes| config.semantics.lanes = lanes);
        vary(&mut configs, self.rules, |config, rules| config.semantics.rules = rules);
        vary(&mut configs, self.formats, |config, name| config.semantics.format = name.parse().expect("a format"));
        vary(&mut configs, self.io, |config, io| config.microarchitecture.io = io);
        vary(&mut configs, self.registers, |config, registers| config.microarchitecture.registers = registers);
        vary(&mut configs, self.control, |config, control| config.microarchitecture.control = control);
        vary(&mut configs, self.sharing, |config, sharing| config.microarchitecture.sharing = sharing);
        vary(&mut configs, self.unit_latency, |config, latency| config.microarchitecture.unit_latency = latency);
        vary(&mut configs, self.units, |config, units| config.microarchitecture.units = units);
        vary(&mut configs, self.interval, |config, interval| config.microarchitecture.interval = interval);
        vary(&mut configs, self.clock_gating, |config, gated| config.microarchitecture.clock_gating = gated);
        vary(&mut configs, self.multiplier, |config, multiplier| config.microarchitecture.multiplier = multiplier);
        configs
    }
}

fn distinct(configs: impl Iterator<Item = Config>) -> Vec<Config> {
    let mut found = Vec::new();
    configs.for_each(|config| {
        if !found.contains(&config) {
            found.push(config);
        }
    });
    found
}

/// Replaces each configuration by its variants with each value of a parameter.
fn vary<T: Copy>(configs: &mut Vec<Config>, values: &[T], set: impl Fn(&mut Config, T)) {
    let with = |config: &Config, value: T| {
        let mut config = *config;
        set(&mut config, value);
        config
    };
    *configs = configs.iter().flat_map(|config| values.iter().map(|&value| with(config, value))).collect();
}

/// Runs all checks of a configuration.
fn check(config: Config, seed: u64, jobs: usize) {
    let model = Datapath::paper(config).model();
    let mut netlist = NetlistEngine::new(model.clone(), config, RegressionChecks::observes)
        .unwrap_or_else(|error| panic!("{config}: {error}"));
    RegressionChecks { config, seed, jobs }
        .check(&mut netlist, &model)
        .unwrap_or_else(|failed| panic!("{config}, {}: {}", failed.check, failed.what));
}

#[test]
fn a_space_has_every_combination_once() {
    let space = Space { lanes: Lanes::ALL, formats: &["fp32", "fp16"], control: Control::ALL, ..DEFAULT };
    let configs = space.configs();
    assert_eq!(configs.len(), 28);
    for (index, config) in configs.iter().enumerate() {
        assert!(!configs[..index].contains(config), "{config}");
    }
    let last = Config::DEFAULT.lanes(Lanes::SixtyFour).format(Format::BINARY16).control(Control::Credit);
    assert_eq!((configs[0].semantics.lanes, configs.last()), (Lanes::None, Some(&last)));
    assert_eq!(DEFAULT.configs(), [Config::DEFAULT]);
}
