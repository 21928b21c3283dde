//! The configurations whose operations are proved.

use super::design::Design;
use super::problem::{Pipeline, Problem};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_float::Format;
use raypath_ops::operations::{NAMES, key_compare, octbox, point_in_box, quantised_box, sphere};
use raypath_ops::{BoxBits, Culling, Operation, Rounding, Rules};
use raypath_rtl::{
    Accumulators, Config, Control, Datapath, Encoding, Interval, Lanes, Multiplier, OperationVisitor, Operations,
    PRESETS, Semantics, Sharing, UnitLatency, UnitSharing,
};
use raypath_verify::{Error, Level};
use std::fmt;

/// A configuration, and an operation in addition to the paper's.
#[derive(Debug, Clone, Copy, Default)]
pub struct Subject {
    /// The configuration.
    pub config: Config,
    /// The name of the added operation.
    pub added: Option<&'static str>,
    /// The elaborator assigns all stages.
    pub is_scheduled: bool,
}

impl From<Config> for Subject {
    fn from(config: Config) -> Self {
        Self { config, ..Self::default() }
    }
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.config)?;
        self.added.map_or(Ok(()), |added| write!(f, " with {added}"))?;
        if self.is_scheduled { f.write_str(", automatic stages") } else { Ok(()) }
    }
}

/// The chosen subjects of a level.
///
/// Regression: some presets and representatives of the parameters. Full: all presets, every value of every parameter,
/// all features, all added operations, automatic stages.
pub(super) fn chosen(level: Level) -> Vec<Subject> {
    let plain = Subject::from;
    let with = |config, added| Subject { config, added: Some(added), is_scheduled: false };
    let small = Config::DEFAULT.lanes(Lanes::Two);
    let features = small.barycentrics(true).culling(Culling::None).facing(true).range(true).tag(7);
    let mut subjects = vec![
        plain(Config::DEFAULT),
        plain(small.control(Control::Credit).rules(Rules::Chisel)),
        plain(small.interval(Interval::Four).io(Encoding::Recoded)),
        plain(small.unit_latency(UnitLatency::Three).sharing(Sharing::Segregated).clock_gating(true)),
        plain(small.units(UnitSharing::Disjoint).exception_flags(true).accumulators(Accumulators::Four)),
        plain(features.multiplier(Multiplier::Inferred).exception_flags(true).unit_latency(UnitLatency::Two)),
        plain(small.lanes(Lanes::None).rules(Rules::Bounds(BoxBits::DEFAULT))),
        with(small, quantised_box::QuantisedBox::NAME),
    ];
    if level == Level::Regression {
        return subjects;
    }
    subjects.extend(PRESETS.iter().map(|preset| plain(preset.config)));
    subjects.extend(NAMES.iter().map(|name| with(small, name)));
    let scheduled = [Config::DEFAULT, small.rules(Rules::Chisel), features.control(Control::Credit)];
    subjects.extend(scheduled.map(|config| Subject { is_scheduled: true, ..plain(config) }));
    subjects
        .extend([small.conservative(true), small.barycentrics(true), small.facing(true), small.range(true)].map(plain));
    subjects.extend(Accumulators::ALL.iter().map(|&accumulators| plain(small.accumulators(accumulators))));
    subjects.extend([Lanes::Four, Lanes::Sixteen].map(|lanes| plain(small.lanes(lanes).rounding(Rounding::Sum))));
    subjects.extend(Interval::ALL.iter().map(|&interval| plain(Config::DEFAULT.interval(interval))));
    subjects
}

/// A configuration, with each of these added operations by itself if there are any.
pub(super) fn of(config: Config, added: &[String]) -> Vec<Subject> {
    let known = NAMES.iter().filter(|name| added.iter().any(|other| other == *name));
    let with_each: Vec<Subject> = known.map(|name| Subject { added: Some(name), ..config.into() }).collect();
    if with_each.is_empty() { vec![config.into()] } else { with_each }
}

/// The random subjects of a level.
pub(super) fn random(level: Level, seed: u64) -> Vec<Subject> {
    let random = &mut ChaCha8Rng::seed_from_u64(seed);
    let sample = std::iter::repeat_with(|| sampled(random)).filter(|subject| subject.config.check().is_ok());
    sample.take(level.pick(0, SAMPLE, 4 * SAMPLE)).collect()
}

/// Random configurations at level full.
const SAMPLE: usize = 200;

/// A configuration in which every parameter has a random value; one in five has an added operation, with the default
/// operations beside it, and one in five automatic stages. It may be none that can be built.
fn sampled(random: &mut ChaCha8Rng) -> Subject {
    let config = sampled_config(random);
    match random.random_range(0..5) {
        0 => {
            let config = Config { semantics: Config::DEFAULT.lanes(Lanes::Two).semantics, ..config };
            let added = NAMES[random.random_range(0..NAMES.len())];
            // Z3 has no answer within the limit for eight sorted boxes in the layout of IEEE 754.
            let config = if added == octbox::Octbox::NAME { config.registers(Encoding::Recoded) } else { config };
            Subject { added: Some(added), ..config.into() }
        }
        1 => Subject { is_scheduled: true, ..config.into() },
        _ => config.into(),
    }
}

fn sampled_config(random: &mut ChaCha8Rng) -> Config {
    fn one<T: Copy>(random: &mut ChaCha8Rng, values: &[T]) -> T {
        values[random.random_range(0..values.len())]
    }
    let rules = [Rules::Paper, Rules::Chisel, Rules::Bounds(BoxBits(random.random_range(8..=24)))];
    let formats =
        ["fp32", "fp32", "fp16", "bf16", "tf32", "e5s4", "e11s24"].map(|name| name.parse().unwrap_or(Format::BINARY32));
    let config = Config::DEFAULT
        .lanes(one(random, Lanes::ALL))
        .rules(one(random, &rules))
        .format(one(random, &formats))
        .io(one(random, Encoding::ALL))
        .registers(one(random, &[Encoding::Recoded, Encoding::Recoded, Encoding::Recoded, Encoding::Ieee]))
        .control(one(random, Control::ALL))
        .sharing(one(random, Sharing::ALL))
        .units(one(random, UnitSharing::ALL))
        .interval(one(random, Interval::ALL))
        .unit_latency(one(random, UnitLatency::ALL))
        .clock_gating(random.random())
        .multiplier(one(random, Multiplier::ALL))
        .tag(one(random, &[0, 1, 8, 32]))
        .barycentrics(random.random())
        .culling(one(random, &[Culling::Back, Culling::Front, Culling::None]))
        .facing(random.random())
        .range(random.random())
        .accumulators(one(random, Accumulators::ALL))
        .exception_flags(random.random());
    // Z3 has no answer within the limit for the sums of more lanes in the layout of IEEE 754.
    if config.semantics.lanes > Lanes::Sixteen { config.registers(Encoding::Recoded) } else { config }
}

impl Subject {
    /// The datapath.
    ///
    /// # Errors
    /// It cannot be elaborated.
    pub(super) fn elaborate(&self) -> Result<Datapath, Error> {
        if self.added.is_none() && !self.is_scheduled {
            return Ok(Datapath::new(self.config)?);
        }
        let Semantics { format, rounding, features, .. } = self.config.semantics;
        let mut operations = Operations::new().format(format).rounding(rounding).tag(features.tag);
        operations = operations.exception_flags(features.exception_flags);
        if self.is_scheduled {
            operations = operations.auto();
        }
        self.config.semantics.operations(&mut operations)?;
        self.added.map_or(Ok(()), |name| added(name, &mut operations))?;
        Ok(Datapath::build(operations, self.config.microarchitecture)?)
    }

    /// The problems of all operations of the datapath, of which `design` is the text, perhaps with a fault in a stage.
    pub(super) fn problems(
        &self,
        datapath: &Datapath,
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

    /// In folded pipelines with automatic stages a step can read a register and encode the next value of the same one.
    /// A third of the sample: at level `full` the item `operations` builds all of it.
    #[test]
    fn automatic_stages_can_be_built() {
        for subject in random(Level::Full, 1).iter().filter(|subject| subject.is_scheduled).step_by(3) {
            if let Err(problem) = subject.elaborate() {
                panic!("{subject}: {problem}");
            }
        }
    }
}
