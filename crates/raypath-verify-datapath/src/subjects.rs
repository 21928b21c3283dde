//! The datapaths that campaigns run: a configuration, and added operations.

use raypath_float::Format;
use raypath_ops::{BoxBits, Culling, Rounding, Rules};
use raypath_oracle::added_operations;
use raypath_rtl::{Accumulators, Config, Interval, Lanes, Multiplier, PRESETS, UnitLatency};
use raypath_sim::Datapath;
use raypath_verify::Request;
use std::fmt;

/// A datapath.
#[derive(Debug, Clone, PartialEq)]
pub struct Subject {
    /// The configuration.
    pub config: Config,
    /// The names of the operations in addition to the configuration's.
    pub added: Vec<String>,
}

impl Subject {
    /// The datapath of a request.
    pub fn of(request: &Request<'_>) -> Self {
        Self { config: request.config, added: request.added.clone() }
    }

    /// The datapath of a configuration with these operations in addition.
    pub fn with(config: Config, added: &[&str]) -> Self {
        Self { config, added: added.iter().map(ToString::to_string).collect() }
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
        Self { config, added: Vec::new() }
    }
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.config)?;
        if self.added.is_empty() { Ok(()) } else { write!(f, ", with {}", self.added.join(", ")) }
    }
}

/// The formats besides the presets', from the least to the greatest.
const FORMATS: [&str; 9] = ["bf16", "tf32", "e3s3", "e3s5", "e4s7", "e5s8", "e6s19", "e11s3", "e11s24"];

/// All datapaths of the campaigns: each preset, feature, added operation and number of lanes, several formats, the
/// other rules and the other rounding, and combinations of them.
pub fn all() -> Vec<Subject> {
    let small = Config::DEFAULT.lanes(Lanes::Two);
    let boxes = Config::DEFAULT.lanes(Lanes::None);
    let bounds = |bits| boxes.rules(Rules::Bounds(BoxBits::DEFAULT)).box_bits(BoxBits(bits));
    let mut configs: Vec<Config> = PRESETS.iter().map(|preset| preset.config).collect();
    configs.extend(Lanes::ALL.iter().map(|&lanes| Config::DEFAULT.lanes(lanes)));
    configs.extend(Lanes::ALL.iter().map(|&lanes| Config::DEFAULT.lanes(lanes).rounding(Rounding::Sum)));
    let formats = FORMATS.iter().filter_map(|name| name.parse().ok());
    configs.extend(formats.map(|format| small.lanes(Lanes::Four).format(format)));
    configs.extend((8..=24).map(bounds));
    configs.extend([
        small.tag(32),
        small.barycentrics(true).facing(true),
        small.culling(Culling::Front),
        small.range(true).culling(Culling::None),
        small.range(true).culling(Culling::None).rules(Rules::Chisel),
        small.exception_flags(true).range(true).conservative(true),
        bounds(13).exception_flags(true),
        small.multiplier(Multiplier::Inferred).unit_latency(UnitLatency::Two),
        small.interval(Interval::Four),
    ]);
    let accumulators = Accumulators::ALL.iter().skip(1);
    configs.extend(accumulators.map(|&accumulators| small.lanes(Lanes::Four).accumulators(accumulators)));
    let mut subjects: Vec<Subject> = configs.into_iter().map(Subject::from).collect();
    subjects.extend([
        Subject::with(boxes, &["key_compare", "octbox"]),
        Subject::with(boxes, &["point_in_box", "sphere"]),
        Subject::with(boxes.format(Format::BINARY16), &["octbox", "quantised_box", "sphere"]),
        Subject::with(
            small.exception_flags(true).tag(5),
            &["key_compare", "octbox", "point_in_box", "quantised_box", "sphere"],
        ),
    ]);
    subjects
}
