//! The configurations whose operations are proved.

use super::design::Design;
use super::problem::{Pipeline, Problem};
use crate::covering::{Space, presets_and_pairs};
use raypath_ops::operations::{NAMES, key_compare, octbox, point_in_box, quantised_box, sphere};
use raypath_ops::{BoxBits, Culling, Operation, Rules};
use raypath_rtl::{
    Accumulators, Config, Control, DatapathNetlist, Encoding, Interval, Lanes, Multiplier, OperationVisitor,
    Operations, Sharing, UnitLatency, UnitSharing,
};
use raypath_verify::{Error, Level};
use std::fmt;

/// A configuration, and an operation in addition to the paper's.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ProvedDatapath {
    /// The configuration.
    pub config: Config,
    /// The name of the added operation.
    pub added: Option<&'static str>,
    /// The elaborator assigns all stages.
    pub is_scheduled: bool,
}

impl From<Config> for ProvedDatapath {
    fn from(config: Config) -> Self {
        Self { config, ..Self::default() }
    }
}

impl fmt::Display for ProvedDatapath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.config)?;
        self.added.map_or(Ok(()), |added| write!(f, " with {added}"))?;
        if self.is_scheduled { f.write_str(", automatic stages") } else { Ok(()) }
    }
}

/// The subjects of a level. Regression: the default and representatives of the parameters. Full: all presets, every
/// pair of values of the parameters with few lanes, all added operations, automatic stages.
///
/// # Errors
/// None, as long as lanes have the values that are given here.
pub(super) fn chosen(level: Level) -> Result<Vec<ProvedDatapath>, Error> {
    let plain = ProvedDatapath::from;
    let with = |config, added| ProvedDatapath { config, added: Some(added), is_scheduled: false };
    let small = Config::DEFAULT.lanes(Lanes::Two);
    let features = small.barycentrics(true).culling(Culling::None).facing(true).range(true).tag(7);
    if level == Level::Regression {
        // With a memory at the exit.
        let deep = small.lanes(Lanes::None).control(Control::Credit).unit_latency(UnitLatency { sums: 5, products: 4 });
        return Ok(vec![
            plain(Config::DEFAULT),
            plain(small.control(Control::Credit).rules(Rules::Chisel)),
            plain(small.interval(Interval::Four).io(Encoding::Recoded)),
            plain(small.unit_latency(UnitLatency::THREE).sharing(Sharing::Segregated).clock_gating(true)),
            plain(small.units(UnitSharing::Disjoint).exception_flags(true).accumulators(Accumulators::Four)),
            plain(features.multiplier(Multiplier::Inferred).exception_flags(true).unit_latency(UnitLatency::TWO)),
            plain(small.lanes(Lanes::None).rules(Rules::Bounds(BoxBits::DEFAULT))),
            plain(deep.multiplier(Multiplier::Dsp).delay_lines(4)),
            with(small, quantised_box::QuantisedBox::NAME),
        ]);
    }
    let scheduled = [Config::DEFAULT, small.rules(Rules::Chisel), features.control(Control::Credit)];
    // More lanes, and registers of IEEE 754, for which Z3 has seldom an answer in time, are in the presets.
    let space = Space::new(&|_| true).with("lanes", &["2", "none", "4"])?.with("registers", &["recoded"])?;
    let mut subjects: Vec<ProvedDatapath> = presets_and_pairs(&space).into_iter().map(ProvedDatapath::from).collect();
    subjects.extend(NAMES.iter().map(|name| with(small, name)));
    subjects.extend(scheduled.map(|config| ProvedDatapath { is_scheduled: true, ..plain(config) }));
    Ok(subjects)
}

/// A configuration, with each of these added operations by itself if there are any.
pub(super) fn of(config: Config, added: &[String]) -> Vec<ProvedDatapath> {
    let known = NAMES.iter().filter(|name| added.iter().any(|other| other == *name));
    let with_each: Vec<ProvedDatapath> =
        known.map(|name| ProvedDatapath { added: Some(name), ..config.into() }).collect();
    if with_each.is_empty() { vec![config.into()] } else { with_each }
}

impl ProvedDatapath {
    /// The datapath.
    ///
    /// # Errors
    /// It cannot be elaborated.
    pub(super) fn elaborate(&self) -> Result<DatapathNetlist, Error> {
        if self.added.is_none() && !self.is_scheduled {
            return Ok(DatapathNetlist::new(self.config)?);
        }
        let mut operations = Operations::empty(self.config.semantics);
        if self.is_scheduled {
            operations = operations.auto();
        }
        self.config.semantics.operations(&mut operations)?;
        self.added.map_or(Ok(()), |name| added(name, &mut operations))?;
        Ok(DatapathNetlist::build(operations, self.config.microarchitecture)?)
    }

    /// The problems of all operations of the datapath, of which `design` is the text, perhaps with a fault in a stage.
    pub(super) fn problems(
        &self,
        datapath: &DatapathNetlist,
        design: &Design,
        has_fault: bool,
    ) -> Result<Vec<Problem>, Error> {
        let has_added = self.added.is_some();
        let pipeline = Pipeline { config: self.config, latency: datapath.latency(), has_added, has_fault, design };
        let mut problems = Problems { pipeline, all: Vec::new() };
        self.config.semantics.operations(&mut problems)?;
        self.added.map_or(Ok(()), |name| added(name, &mut problems))?;
        Ok(problems.all)
    }
}

/// The opcode of the added operation.
const ADDED: u64 = 4;

/// Shows the added operation of this name.
fn added<V: OperationVisitor>(name: &str, visitor: &mut V) -> Result<(), V::Error> {
    match name {
        key_compare::KeyCompare::NAME => visitor.visit(key_compare::KeyCompare, ADDED),
        octbox::Octbox::NAME => visitor.visit(octbox::Octbox, ADDED),
        point_in_box::PointInBox::NAME => visitor.visit(point_in_box::PointInBox, ADDED),
        quantised_box::QuantisedBox::NAME => visitor.visit(quantised_box::QuantisedBox, ADDED),
        sphere::Sphere::NAME => visitor.visit(sphere::Sphere, ADDED),
        _ => Ok(()),
    }
}

/// Makes a problem of each operation.
struct Problems<'d> {
    pipeline: Pipeline<'d>,
    all: Vec<Problem>,
}

impl OperationVisitor for Problems<'_> {
    type Error = Error;

    fn visit<O: Operation + Send + Sync + 'static>(&mut self, operation: O, opcode: u64) -> Result<(), Error> {
        self.all.push(Problem::new(self.pipeline, &operation, opcode)?);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chosen_configuration_is_proved_with_each_added_operation() {
        let config = Config::DEFAULT.lanes(Lanes::Two);
        let added = |names: &[&str]| {
            let names: Vec<String> = names.iter().map(|name| name.to_string()).collect();
            of(config, &names).into_iter().map(|subject| (subject.config, subject.added)).collect::<Vec<_>>()
        };
        assert_eq!(added(&[]), [(config, None)]);
        assert_eq!(added(&["sphere", "octbox"]), [(config, Some("octbox")), (config, Some("sphere"))]);
    }
}
