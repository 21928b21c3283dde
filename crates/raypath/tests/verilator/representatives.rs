//! Configurations that together contain every value of every parameter.

use raypath::float::Format;
use raypath::ops::Rules;
use raypath::rtl::{Config, Control, Encoding, Lanes, Multiplier, PARAMETER_GROUPS, Sharing, UnitLatency};

const DEFAULT: Config = Config::DEFAULT;

/// No two of these share more than half of their parameters. Tests add the default and `lanes none`.
pub const REPRESENTATIVES: [Config; 6] = [
    DEFAULT
        .lanes(Lanes::Two)
        .io(Encoding::Recoded)
        .registers(Encoding::Ieee)
        .control(Control::Credit)
        .multiplier(Multiplier::Inferred),
    DEFAULT
        .lanes(Lanes::Four)
        .io(Encoding::Recoded)
        .sharing(Sharing::Segregated)
        .unit_latency(UnitLatency::Two)
        .clock_gating(true),
    DEFAULT
        .lanes(Lanes::Eight)
        .registers(Encoding::Ieee)
        .rules(Rules::Chisel)
        .format(Format::TF32)
        .control(Control::Credit)
        .unit_latency(UnitLatency::Three)
        .multiplier(Multiplier::Inferred),
    DEFAULT.lanes(Lanes::ThirtyTwo).format(Format::BFLOAT16).control(Control::Credit).clock_gating(true),
    DEFAULT.lanes(Lanes::SixtyFour).format(Format::BINARY16),
    DEFAULT.lanes(Lanes::None).rules(Rules::Chisel).control(Control::Credit),
];

/// Checks the claim of the list.
#[test]
fn every_value_of_every_parameter_is_represented() {
    let all = || REPRESENTATIVES.into_iter().chain([DEFAULT]);
    for parameter in PARAMETER_GROUPS[..2].iter().flat_map(|group| group.parameters) {
        for value in parameter.values.split('|').filter(|&value| value != "eXsY") {
            assert!(all().any(|config| parameter.get(&config) == value), "{} {value}", parameter.name);
        }
    }
}
