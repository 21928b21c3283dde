//! The datapaths that campaigns run: a configuration, and added operations.

use crate::oracle::Mistake;
use raypath_float::Format;
use raypath_ops::{BoxBits, Culling, Rounding, Rules};
use raypath_oracle::added_operations;
use raypath_rtl::{Accumulators, Config, Interval, Lanes, Multiplier, PRESETS, UnitLatency};
use raypath_sim::Datapath;
use raypath_verify::Request;
use std::fmt;

/// A datapath, and a deliberate mistake that a comparison with it must report.
#[derive(Debug, Clone, PartialEq)]
pub struct Subject {
    /// The configuration.
    pub config: Config,
    /// The names of the operations in addition to the configuration's.
    pub added: Vec<String>,
    /// The mistake of the negative control.
    pub mistake: Mistake,
}

impl Subject {
    /// The datapath of a request.
    pub fn of(request: &Request<'_>) -> Self {
        Self { added: request.added.clone(), ..Self::from(request.config) }
    }

    /// The datapath.
    pub fn datapath(&self) -> Datapath {
        let added = added_operations().into_iter().filter(|spec| self.added.iter().any(|name| name == spec.name()));
        added.fold(Datapath::paper(self.config), |datapath, spec| datapath.with_any(spec.operation()))
    }

    /// The command-line options that select the datapath.
    pub fn options(&self) -> String {
        let with = if self.added.is_empty() { String::new() } else { format!("--with {}", self.added.join(",")) };
        [with, self.config.options()].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
    }
}

/// A datapath without added operations.
impl From<Config> for Subject {
    fn from(config: Config) -> Self {
        of(config, Mistake::ShortSignificand)
    }
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.config)?;
        if self.added.is_empty() { Ok(()) } else { write!(f, ", with {}", self.added.join(", ")) }
    }
}

/// All datapaths of the campaigns: each preset, feature, added operation and number of lanes, several formats, the
/// other rules and the other rounding, and combinations of them.
pub fn all() -> Vec<Subject> {
    let small = Config::DEFAULT.lanes(Lanes::Two);
    let boxes = Config::DEFAULT.lanes(Lanes::None);
    let mut subjects: Vec<Subject> = PRESETS.iter().map(|preset| of(preset.config, Mistake::TiesAway)).collect();
    subjects.extend(Lanes::ALL.iter().map(|&lanes| {
        let mistake = match lanes {
            Lanes::None => Mistake::OpenEdges,
            Lanes::Two => Mistake::MasksIgnored,
            Lanes::Four | Lanes::Eight => Mistake::NeverRestarted,
            _ => Mistake::Neighbours,
        };
        of(Config::DEFAULT.lanes(lanes), mistake)
    }));
    let formats = ["fp16", "bf16", "tf32", "e3s3", "e3s5", "e4s7", "e5s8", "e6s19", "e11s3", "e11s24"];
    subjects.extend(formats.iter().filter_map(|name| {
        let format: Format = name.parse().ok()?;
        Some(of(small.lanes(Lanes::Four).format(format), Mistake::FlushedSubnormals))
    }));
    let rules = |bits| boxes.rules(Rules::Bounds(BoxBits::DEFAULT)).box_bits(BoxBits(bits));
    subjects.extend((8..=24).map(|bits| of(rules(bits), Mistake::StrictBoxes)));
    subjects.push(of(rules(24), Mistake::NoMargin));
    subjects.push(of(rules(8).format(Format::BFLOAT16), Mistake::TiesReversed));
    subjects.extend(Lanes::ALL.iter().map(|&lanes| {
        let config = Config::DEFAULT.lanes(lanes).rounding(Rounding::Sum);
        // The sums of three terms of triangles have a window too.
        of(config, Mistake::ShortWindow)
    }));
    subjects.push(of(rules(11).format(Format::BINARY16).rounding(Rounding::Sum), Mistake::ShortWindow));
    subjects.extend([
        of(small.tag(1), Mistake::DirectionIgnored),
        of(small.tag(32), Mistake::ExtentIgnored),
        of(small.barycentrics(true), Mistake::OtherOrder),
        of(small.facing(true), Mistake::TiesAway),
        of(small.culling(Culling::Front), Mistake::CullingIgnored),
        of(small.culling(Culling::None), Mistake::OpenEdges),
        of(small.range(true), Mistake::OtherOrder),
        of(small.range(true).culling(Culling::None), Mistake::OtherOrder),
        of(small.range(true).culling(Culling::None).rules(Rules::Chisel), Mistake::OpenRange),
        of(small.range(true).culling(Culling::Front).format(Format::BINARY16), Mistake::OtherOrder),
        of(small.conservative(true), Mistake::StrictBoxes),
        of(small.conservative(true).format(Format::BINARY16), Mistake::StrictBoxes),
        of(small.quantised_boxes(true).exception_flags(true), Mistake::UnusedChildren),
        of(small.exception_flags(true), Mistake::NoUnderflow),
        of(small.exception_flags(true).range(true).conservative(true), Mistake::NoUnderflow),
        of(rules(13).exception_flags(true), Mistake::NoUnderflow),
        of(small.multiplier(Multiplier::Inferred).unit_latency(UnitLatency::Two), Mistake::TiesAway),
        of(small.interval(Interval::Four), Mistake::MasksIgnored),
    ]);
    subjects.extend(
        Accumulators::ALL
            .iter()
            .skip(1)
            .map(|&accumulators| of(small.lanes(Lanes::Four).accumulators(accumulators), Mistake::OneAccumulator)),
    );
    let with = |config, names: &[&str], mistake| Subject {
        config,
        added: names.iter().map(ToString::to_string).collect(),
        mistake,
    };
    subjects.extend([
        with(boxes, &["key_compare"], Mistake::StrictKeys),
        with(boxes, &["octbox"], Mistake::TiesReversed),
        with(boxes, &["point_in_box"], Mistake::OpenPoints),
        with(boxes, &["quantised_box"], Mistake::UnusedChildren),
        with(boxes, &["sphere"], Mistake::SpheresBehind),
        with(boxes.format(Format::BINARY16), &["octbox", "quantised_box", "sphere"], Mistake::TiesAway),
        with(
            small.exception_flags(true).tag(5),
            &["key_compare", "octbox", "point_in_box", "quantised_box", "sphere"],
            Mistake::NoUnderflow,
        ),
    ]);
    subjects
}

fn of(config: Config, mistake: Mistake) -> Subject {
    Subject { config, added: Vec::new(), mistake }
}
