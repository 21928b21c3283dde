//! The variety of the random jobs: tests with uniform jobs would pass without finding faults.
//!
//! Known bug: tests of CVFPU once used equal values in all lanes of a vector, and a fault between lanes stayed hidden.
//! These tests count the classes, sequences and outcomes of the jobs that [`random`] makes.
//!
//! Mutation: in `jobs.rs`, no edge cases (or only edge cases), masks of all ones, operations in a fixed sequence.

use raypath::float::Format;
use raypath::model::Model;
use raypath::ops::{JobKind, PortKind};
use raypath::rtl::{Config, Lanes};
use raypath::sim::Datapath;
use raypath::sim::jobs::random;
use std::collections::{BTreeMap, BTreeSet};

const JOBS: usize = 20_000;

/// The class of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Class {
    Zero(bool),
    Subnormal(bool),
    Normal(bool),
    Infinity(bool),
    Nan,
}

fn class(format: Format, code: u64) -> Class {
    let minus = code >> (format.ieee_width() - 1) & 1 == 1;
    let magnitude = code & ((1 << (format.ieee_width() - 1)) - 1);
    match magnitude {
        0 => Class::Zero(minus),
        _ if magnitude > format.infinity() => Class::Nan,
        _ if magnitude == format.infinity() => Class::Infinity(minus),
        _ if magnitude >> format.fraction_width() == 0 => Class::Subnormal(minus),
        _ => Class::Normal(minus),
    }
}

/// All nine.
const CLASSES: usize = 9;

#[derive(Default)]
struct Census {
    /// For each number port, the count of each class.
    classes: BTreeMap<String, BTreeMap<Class, usize>>,
    /// The values of each other port.
    words: BTreeMap<String, BTreeSet<u64>>,
    /// Pairs of operations that followed each other.
    pairs: BTreeSet<(u64, u64)>,
    /// The outcomes: which boxes were hit and in which order, and whether triangles were hit.
    hits: BTreeMap<String, BTreeMap<u64, usize>>,
    /// Jobs with only normal, nonzero numbers.
    ordinary: usize,
}

fn take(config: Config) -> Census {
    let mut model = Datapath::paper(config).model();
    let mut census = Census::default();
    let mut last = None;
    for job in random(&model.clone(), config.semantics.format, 1, config.kinds()).take(JOBS) {
        census.pairs.extend(last.map(|last| (last, job.kind().opcode())));
        last = Some(job.kind().opcode());
        let mut is_ordinary = true;
        for port in job.ports() {
            // Ports of different operations are counted separately.
            let name = format!("{} {}", job.kind(), port.name);
            if port.kind == PortKind::Number {
                let class = class(config.semantics.format, port.bits);
                is_ordinary &= matches!(class, Class::Normal(_));
                *census.classes.entry(name).or_default().entry(class).or_default() += 1;
            } else {
                census.words.entry(name).or_default().insert(port.bits);
            }
        }
        census.ordinary += usize::from(is_ordinary);
        let outcome = model.run(&job);
        for port in outcome.ports() {
            if ["triangle_hit", "is_intersect"].contains(&port.name.as_str()) {
                *census.hits.entry(port.name).or_default().entry(port.bits).or_default() += 1;
            }
        }
        if job.kind() == JobKind::Quadbox {
            let places = outcome.ports().into_iter().filter(|port| port.name.starts_with("box_index"));
            let order = places.fold(0, |order, port| order << 2 | port.bits);
            *census.hits.entry("order".to_string()).or_default().entry(order).or_default() += 1;
        }
    }
    census
}

#[test]
fn every_port_sees_every_class_of_number_and_mostly_ordinary_ones() {
    for format in [Format::BINARY32, Format::BINARY16] {
        let census = take(Config::DEFAULT.format(format));
        assert!(census.classes.len() > 4 * 16);
        for (port, classes) in &census.classes {
            assert_eq!(classes.len(), CLASSES, "{format}, {port}: {classes:?}");
            let all: usize = classes.values().sum();
            let normal: usize = [false, true].iter().filter_map(|minus| classes.get(&Class::Normal(*minus))).sum();
            assert!((all / 4..all).contains(&normal), "{format}, {port}: {normal} of {all} are normal");
        }
        // There are also jobs without edge cases, because an edge case can hide later faults.
        assert!((JOBS / 20..JOBS * 9 / 10).contains(&census.ordinary), "{format}: {} ordinary jobs", census.ordinary);
    }
}

#[test]
fn every_kind_follows_every_kind() {
    assert_eq!(take(Config::DEFAULT).pairs.len(), 16);
    assert_eq!(take(Config::DEFAULT.lanes(Lanes::None)).pairs.len(), 4);
}

/// Masks vary: every lane is on beside a lane that is off, and off beside a lane that is on.
#[test]
fn masks_axes_and_resets_take_all_values() {
    let census = take(Config::DEFAULT);
    for (port, values) in &census.words {
        match port.split(' ').nth(1).unwrap_or_default() {
            "euclidean_reset_accum" => assert_eq!(values.len(), 2, "{port}"),
            "ray_kx" | "ray_ky" | "ray_kz" => assert_eq!(values.len(), 4, "{port}"),
            "euclidean_mask" => assert!(values.len() > 200, "{port}: {} masks", values.len()),
            other => panic!("{other}: a port that this test does not check"),
        }
    }
}

#[test]
fn neighbouring_lanes_are_on_and_off() {
    for (lanes, format) in
        [(Lanes::Two, "fp32"), (Lanes::Sixteen, "e3s3"), (Lanes::SixtyFour, "fp16"), (Lanes::SixtyFour, "fp32")]
    {
        let config = Config::DEFAULT.lanes(lanes).format(format.parse().expect("a format"));
        let masks = take(config).words.remove("euclidean euclidean_mask").expect("masks");
        for lane in 0..lanes.count() - 1 {
            let pairs: BTreeSet<u64> = masks.iter().map(|mask| mask >> lane & 3).collect();
            assert_eq!(pairs.len(), 4, "lanes {lane} and {} of {lanes}, {format}: {pairs:?}", lane + 1);
        }
        // A random mask has about half of the lanes; one in ten thousand of 64 has fewer than a quarter.
        let all = u64::MAX >> (64 - lanes.count());
        let some: Vec<u64> = masks.iter().copied().filter(|mask| ![0, all].contains(mask)).collect();
        let many = some.iter().filter(|mask| mask.count_ones() as usize * 4 >= lanes.count()).count();
        assert!(many * 10 >= some.len() * 9, "{lanes} lanes, {format}: {many} of {} masks have many lanes", some.len());
    }
}

#[test]
fn boxes_and_triangles_are_hit_and_missed_in_every_order() {
    let census = take(Config::DEFAULT);
    let share = |name: &str, value: u64| census.hits[name].get(&value).copied().unwrap_or(0);
    assert!(share("triangle_hit", 0) > JOBS / 40 && share("triangle_hit", 1) > JOBS / 40, "{:?}", census.hits);
    assert_eq!(census.hits["is_intersect"].len(), 5, "0 to 4 boxes hit; hits stand first: {:?}", census.hits);
    assert!(census.hits["is_intersect"].values().all(|&count| count > 50), "{:?}", census.hits["is_intersect"]);
    assert_eq!(census.hits["order"].len(), 24, "all orders of four boxes");
}
