//! Configurations that together contain every value of every parameter.

use raypath_float::Format;
use raypath_ops::{BoxBits, EdgeRule, Rounding, Rules};
use raypath_rtl::{
    Config, Control, Encoding, Interval, Lanes, Multiplier, PARAMETER_GROUPS, Sharing, UnitLatency, UnitSharing,
};

const DEFAULT: Config = Config::DEFAULT;

/// No two of these share more than half of their parameters. Tests add the default and `lanes none`.
pub const REPRESENTATIVES: [Config; 8] = [
    DEFAULT
        .lanes(Lanes::Two)
        .io(Encoding::Recoded)
        .registers(Encoding::Ieee)
        .control(Control::Credit)
        .edges(EdgeRule::Once)
        .multiplier(Multiplier::Inferred),
    DEFAULT
        .lanes(Lanes::Four)
        .io(Encoding::Recoded)
        .sharing(Sharing::Segregated)
        .unit_latency(UnitLatency::TWO)
        .clock_gating(true),
    DEFAULT
        .lanes(Lanes::Eight)
        .registers(Encoding::Ieee)
        .rules(Rules::Chisel)
        .format(Format::TF32)
        .control(Control::Credit)
        .units(UnitSharing::Disjoint)
        .unit_latency(UnitLatency { sums: 7, products: 5 })
        .delay_lines(3)
        .multiplier(Multiplier::Dsp),
    DEFAULT
        .lanes(Lanes::ThirtyTwo)
        .format(Format::BFLOAT16)
        .control(Control::Credit)
        .interval(Interval::Two)
        .unit_latency(UnitLatency { sums: 3, products: 3 })
        .multiplier(Multiplier::Dsp),
    DEFAULT.lanes(Lanes::SixtyFour).format(Format::BINARY16).interval(Interval::Four),
    DEFAULT.lanes(Lanes::None).rules(Rules::Chisel).control(Control::Credit).interval(Interval::Eight),
    DEFAULT
        .lanes(Lanes::Four)
        .rules(Rules::Bounds(BoxBits::DEFAULT))
        .box_bits(BoxBits(9))
        .control(Control::Credit)
        .unit_latency(UnitLatency::TWO),
    DEFAULT
        .lanes(Lanes::Eight)
        .rounding(Rounding::Sum)
        .edges(EdgeRule::Once)
        .sharing(Sharing::Segregated)
        .clock_gating(true),
];

/// Checks the claim of the list.
#[test]
fn every_value_of_every_parameter_is_represented() {
    let all = || REPRESENTATIVES.into_iter().chain([DEFAULT]);
    for parameter in PARAMETER_GROUPS[..2].iter().flat_map(|group| group.parameters) {
        for value in parameter.values.split('|').filter(|&value| value != "eXsY" && !value.contains("..")) {
            assert!(all().any(|config| parameter.get(&config) == value), "{} {value}", parameter.name);
        }
    }
}
