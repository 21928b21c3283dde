//! Each format that raypath reads, as a function of bytes.

use crate::request::{Level, Shard};
use raypath_float::Format;
use raypath_ops::{JobKind, Ray, Rules};
use raypath_ppa::{Baseline, parsers};
use raypath_rtl::{Config, Control, Encoding, Lanes, Preset, Sharing, UnitLatency, parameters};
use raypath_sim::configuration::{parse, parse_sweep};
use raypath_sim::models::{PaperModel, Visitor, with_model};
use raypath_sim::transactions::read_from;
use std::fmt::Display;
use std::path::Path;
use std::str::FromStr;

/// A format and what reads it.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// The fuzz target, and the folder of its corpus.
    pub name: &'static str,
    /// What it reads.
    pub format: &'static str,
    /// Reads it; says whether it was what it should be, and panics where it is taken for what it cannot be.
    pub parse: fn(&[u8]) -> bool,
}

/// All of them.
pub const TARGETS: &[Target] = &[
    target("transactions", "transaction files of every kind, plain and gzip", transactions),
    target("configuration", "configurations in TOML", configuration),
    target("sweep", "sweeps in TOML", sweep),
    target("library", "cell libraries in Liberty, plain and gzip", parsers::library),
    target("yosys_netlist", "synthesised netlists in JSON", parsers::yosys_netlist),
    target("yosys_statistics", "what Yosys's stat prints", parsers::yosys_statistics),
    target("opensta_paths", "what OpenSTA prints", parsers::opensta_paths),
    target("kept_result", "results kept in the cache", parsers::kept_result),
    target("earlier_report", "reports to compare with, in JSON", earlier_report),
    target("arguments", "values of the command line's options", arguments),
];

const fn target(name: &'static str, format: &'static str, parse: fn(&[u8]) -> bool) -> Target {
    Target { name, format, parse }
}

fn transactions(bytes: &[u8]) -> bool {
    let half = Config::DEFAULT.format(Format::BINARY16).lanes(Lanes::Two);
    [Config::DEFAULT, half].map(|config| with_model(config, Transactions { bytes, config })).contains(&true)
}

struct Transactions<'b> {
    bytes: &'b [u8],
    config: Config,
}

impl Visitor for Transactions<'_> {
    type Answer = bool;

    fn visit<M: PaperModel>(self, model: M) -> bool {
        let read = |&kind: &JobKind| read_from(self.bytes, Path::new("jobs.txt"), kind, &model, self.config);
        // Whoever reads a job runs it.
        let run = |jobs: Vec<raypath_sim::transactions::Transaction<M>>| {
            let mut model = model.clone();
            jobs.iter().take(4).for_each(|transaction| _ = model.run(&transaction.job));
            !jobs.is_empty()
        };
        self.config.kinds().iter().map(|kind| read(kind).is_ok_and(run)).fold(false, |any, one| any | one)
    }
}

fn configuration(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    let Ok(config) = parse(text, Path::new("raypath.toml")) else { return false };
    assert_eq!(parse(&as_toml(config), Path::new("again.toml")).ok(), Some(config));
    true
}

fn sweep(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    let Ok(configs) = parse_sweep(text, Path::new("sweep.toml")) else { return false };
    assert!((1..=10_000).contains(&configs.len()));
    // One value of each is a configuration as well.
    if let [(_, config)] = configs.as_slice() {
        assert_eq!(parse(&as_toml(*config), Path::new("again.toml")).ok(), Some(*config));
    }
    true
}

/// A configuration as a file says it.
fn as_toml(config: Config) -> String {
    parameters().map(|parameter| format!("{} = \"{}\"\n", parameter.name, parameter.get(&config))).collect()
}

fn earlier_report(bytes: &[u8]) -> bool {
    let Ok(baseline) = Baseline::parse(bytes, Path::new("ppa.json")) else { return false };
    assert!(baseline.area.total.is_finite() && baseline.slowest.ns.is_finite());
    baseline.stages.iter().all(|stage| baseline.stage(&stage.name).is_some())
}

/// Every line is a value of every option; rays are seven numbers in a line.
fn arguments(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes);
    let mut is_any = false;
    for line in text.lines().take(64) {
        is_any |= same_again::<Format>(line) | same_again::<Shard>(line) | same_again::<Rules>(line);
        is_any |= same_again::<Lanes>(line) | same_again::<Encoding>(line) | same_again::<Control>(line);
        is_any |= same_again::<Sharing>(line) | same_again::<UnitLatency>(line) | same_again::<Preset>(line);
        is_any |= same_again::<JobKind>(line) | line.parse::<Level>().is_ok();
        if let Ok(shard) = line.parse::<Shard>() {
            assert!(shard.share(u64::MAX) >= 1 || shard.number() == u64::MAX);
        }
        let numbers: Vec<f32> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        if let &[x, y, z, u, v, w, extent] = numbers.as_slice() {
            let ray: Result<Ray<raypath_ops::Binary32>, _> = Ray::new([x, y, z], [u, v, w], extent);
            is_any |= ray.is_ok();
        }
    }
    is_any
}

/// Reads a value, and what it prints as.
fn same_again<T: FromStr + Display + PartialEq>(text: &str) -> bool {
    let Ok(value) = text.parse::<T>() else { return false };
    assert!(value.to_string().parse::<T>().is_ok_and(|again| again == value), "{text:?} prints as '{value}'");
    true
}
