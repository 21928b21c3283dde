//! Configurations that have among them every value of every parameter.

use raypath::format::Format;
use raypath::ops::Rules;
use raypath::rtl::{Config, Control, Encoding, Lanes, Sharing, UnitLatency};

const DEFAULT: Config = Config::DEFAULT;

/// None is like another in more than half of its parameters; the default and `lanes none` stand beside them.
pub const REPRESENTATIVES: [Config; 6] = [
    Config { lanes: Lanes::Two, io: Encoding::Recoded, registers: Encoding::Ieee, control: Control::Credit, ..DEFAULT },
    Config {
        lanes: Lanes::Four,
        io: Encoding::Recoded,
        sharing: Sharing::Segregated,
        unit_latency: UnitLatency::Two,
        ..DEFAULT
    },
    Config {
        lanes: Lanes::Eight,
        registers: Encoding::Ieee,
        rules: Rules::Chisel,
        format: Format::TF32,
        control: Control::Credit,
        unit_latency: UnitLatency::Three,
        ..DEFAULT
    },
    Config { lanes: Lanes::ThirtyTwo, format: Format::BFLOAT16, control: Control::Credit, ..DEFAULT },
    Config { lanes: Lanes::SixtyFour, format: Format::BINARY16, ..DEFAULT },
    Config { lanes: Lanes::None, rules: Rules::Chisel, control: Control::Credit, ..DEFAULT },
];

/// The list is what it says.
#[test]
fn every_value_of_every_parameter_is_represented() {
    let all = || REPRESENTATIVES.into_iter().chain([DEFAULT]);
    assert!(Lanes::ALL.iter().all(|&lanes| all().any(|config| config.lanes == lanes)));
    assert!(Encoding::ALL.iter().all(|&io| all().any(|config| config.io == io)));
    assert!(Encoding::ALL.iter().all(|&registers| all().any(|config| config.registers == registers)));
    assert!(Control::ALL.iter().all(|&control| all().any(|config| config.control == control)));
    assert!(Sharing::ALL.iter().all(|&sharing| all().any(|config| config.sharing == sharing)));
    assert!(UnitLatency::ALL.iter().all(|&latency| all().any(|config| config.unit_latency == latency)));
    assert!([Rules::Paper, Rules::Chisel].iter().all(|&rules| all().any(|config| config.rules == rules)));
    let formats = [Format::BINARY32, Format::TF32, Format::BFLOAT16, Format::BINARY16];
    assert!(formats.iter().all(|&format| all().any(|config| config.format == format)));
}
