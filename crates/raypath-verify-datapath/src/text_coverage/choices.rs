//! The designs whose text is covered.

use super::datapath::DatapathDesign;
use super::design::Design;
use super::unit::UnitDesign;
use crate::subjects::Subject;
use raypath_float::Format;
use raypath_ops::operations::NAMES;
use raypath_ops::{BoxBits, Culling, Rounding, Rules};
use raypath_rtl::{
    Accumulators, Config, Control, Encoding, Features, Interval, Lanes, Multiplier, PRESETS, UnitLatency, UnitSharing,
};
use raypath_traversal::UnitParameters;
use raypath_verify::{Error, Level};
use raypath_verify_traversal::campaign::settings;
use std::fmt;

/// A design that can be covered.
pub enum Choice {
    /// A datapath.
    Datapath(Subject),
    /// The traversal unit with these parameters, around a datapath of this configuration.
    Unit(Config, UnitParameters),
}

impl Choice {
    /// Builds the design.
    ///
    /// # Errors
    /// The design cannot be built.
    pub fn open(&self) -> Result<Box<dyn Design>, Error> {
        Ok(match self {
            Self::Datapath(subject) => Box::new(DatapathDesign::new(subject)?),
            Self::Unit(config, parameters) => Box::new(UnitDesign::new(*config, *parameters)?),
        })
    }
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Datapath(subject) => subject.fmt(f),
            Self::Unit(_, parameters) => write!(f, "traversal unit, {parameters}"),
        }
    }
}

/// The designs of a level: a small datapath with features; from level full on also the presets, small ones with each
/// value of each parameter of the microarchitecture but segregated registers, each feature, rule set, rounding and
/// added operation, and the traversal units of their campaign. A preset has segregated registers: with numbers of 10
/// bits, the signs of the distances of boxes, which are 0 in each of these registers, are more than 1 % of the bits.
pub fn choices(level: Level) -> Result<Vec<Choice>, Error> {
    let datapaths = datapaths(level)?.into_iter().map(Choice::Datapath);
    let units = settings().take(level.pick(0, usize::MAX, usize::MAX)).map(|(config, parameters)| {
        // A divider of one cycle waits only if a leaf arrives right after another. No run showed that with 128 or 256
        // bits.
        let block_width = 8 * parameters.step.node.block_bytes();
        let memory_width = if parameters.divider_latency == 1 { block_width } else { parameters.memory_width };
        Choice::Unit(config, UnitParameters { memory_width, ..parameters })
    });
    Ok(datapaths.chain(units).collect())
}

fn datapaths(level: Level) -> Result<Vec<Subject>, Error> {
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
    fn every_design_can_be_built() {
        let choices = choices(Level::Full).expect("choices");
        assert!(choices.len() > 53, "{}", choices.len());
        for choice in choices {
            choice.open().map(|_| ()).unwrap_or_else(|problem| panic!("{choice}: {problem}"));
        }
    }
}
