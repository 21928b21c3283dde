//! The datapaths whose text is covered.

use crate::subjects::Subject;
use crate::{Error, Level};
use raypath_float::Format;
use raypath_ops::operations::NAMES;
use raypath_ops::{BoxBits, Culling, Rounding, Rules};
use raypath_rtl::{
    Accumulators, Config, Control, Encoding, Features, Interval, Lanes, Multiplier, PRESETS, Sharing, UnitLatency,
    UnitSharing,
};

/// The datapaths of a level: a small one with features; from level full on also the presets, and small ones with each
/// value of each parameter of the microarchitecture, each feature, rule set, rounding and added operation.
pub fn subjects(level: Level) -> Result<Vec<Subject>, Error> {
    let small = Config::DEFAULT.lanes(Lanes::Two).format(Format::new(4, 5)?);
    let features =
        Features { tag: 3, barycentrics: true, facing: true, culling: Culling::None, range: true, ..Features::OFF };
    let first = small.features(features);
    if level == Level::Regression {
        return Ok(vec![first.into()]);
    }
    let mut configs = vec![first];
    configs.extend(PRESETS.iter().map(|preset| preset.config));
    for &control in Control::ALL {
        let of = small.control(control);
        configs.extend(UnitLatency::ALL.iter().map(|&latency| of.unit_latency(latency)));
        configs.extend(Interval::ALL.iter().map(|&interval| of.interval(interval)));
        configs.push(of.clock_gating(true));
    }
    configs.extend(Sharing::ALL.iter().map(|&sharing| small.sharing(sharing)));
    configs.extend(UnitSharing::ALL.iter().map(|&units| small.units(units)));
    configs.extend(Multiplier::ALL.iter().map(|&multiplier| small.multiplier(multiplier)));
    for &io in Encoding::ALL {
        configs.extend(Encoding::ALL.iter().map(|&registers| small.io(io).registers(registers)));
    }
    let four = small.lanes(Lanes::Four);
    configs.extend(Accumulators::ALL.iter().map(|&accumulators| four.accumulators(accumulators)));
    configs.extend([
        small.rules(Rules::Chisel),
        small.lanes(Lanes::None).format(Format::BFLOAT16).rules(Rules::Bounds(BoxBits::DEFAULT)).box_bits(BoxBits(8)),
        small.rounding(Rounding::Sum),
        small.culling(Culling::Front),
        small.conservative(true),
        // Bounds of 8 bits need as many in the significand, and exceptions need binary32.
        small.format(Format::BINARY16).quantised_boxes(true),
        small.format(Format::BINARY32).exception_flags(true),
    ]);
    let mut subjects: Vec<Subject> = Vec::new();
    for config in configs {
        if !subjects.iter().any(|known| known.config == config) {
            subjects.push(config.into());
        }
    }
    let boxes = small.lanes(Lanes::None).format(Format::BINARY16);
    subjects.extend(NAMES.iter().map(|name| Subject { added: vec![name.to_string()], ..boxes.into() }));
    Ok(subjects)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_subject_can_be_built() {
        let subjects = subjects(Level::Full).expect("subjects");
        assert!(subjects.len() > 45, "{}", subjects.len());
        for subject in subjects {
            subject.datapath().elaborate().unwrap_or_else(|problem| panic!("{subject}: {problem}"));
        }
    }
}
