//! The readers of all formats that raypath reads, as functions of bytes: what libFuzzer calls.

mod meshes;
mod results;
mod scenes;
mod vectors;

use raypath_float::Format;
use raypath_model::Model;
use raypath_ops::{JobKind, Ray, Rules};
use raypath_ppa::{Baseline, parsers};
use raypath_render::{Camera, Goal, Hit, Mesh, Scene, Tracer, Tracing, draw, parse_hits, parse_instances, write_hits};
use raypath_rtl::{
    Config, Control, Encoding, Interval, Lanes, Multiplier, Preset, Sharing, UnitLatency, UnitSharing, parameters,
};
use raypath_sim::configuration::{parse, parse_sweep};
use raypath_sim::transactions::{Transaction, read_from};
use raypath_verify::Level;
use raypath_work::pool::Shard;
use std::fmt::Display;
use std::path::Path;
use std::str::FromStr;

/// A format and its parser.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// The fuzz target, and the folder of its corpus.
    pub name: &'static str,
    /// The format.
    pub format: &'static str,
    /// Parses a file. Returns whether it is valid; panics if it is accepted with an impossible value.
    pub parse: fn(&[u8]) -> bool,
}

/// All targets.
pub const TARGETS: &[Target] = &[
    target("transactions", "transaction files of every kind, plain and gzip", transactions),
    target("configuration", "configurations in TOML", configuration),
    target("sweep", "sweeps in TOML", sweep),
    target("library", "cell libraries in Liberty, plain and gzip", parsers::library),
    target("yosys_netlist", "synthesised netlists in JSON", parsers::yosys_netlist),
    target("yosys_statistics", "output of Yosys's stat", parsers::yosys_statistics),
    target("opensta_paths", "output of OpenSTA", parsers::opensta_paths),
    target("opensta_power", "OpenSTA's messages about power", parsers::opensta_power),
    target("kept_result", "results in the cache", parsers::kept_result),
    target("earlier_report", "reports to compare with, in JSON", earlier_report),
    target("obj", "meshes in OBJ", meshes::obj),
    target("gltf", "meshes in glTF, text and binary", meshes::gltf),
    target("ply", "meshes in PLY, text and binary", meshes::ply),
    target("stl", "meshes in STL, text and binary", meshes::stl),
    target("rays", "files of rays", meshes::rays),
    target("scene", "scenes in the memory of the traversal unit", scenes::scene),
    target("hits", "hits of rays, with instances and without", hits),
    target("instances", "places of a mesh in a scene", instances),
    target("fvecs", "vectors of floats and of bytes, each after its length", vectors::fvecs),
    target("ivecs", "vectors of integers, and true neighbours", vectors::ivecs),
    target("npy", "arrays of NumPy", vectors::npy),
    target("hdf5", "HDF5 in the layout of ann-benchmarks", vectors::hdf5),
    target("handshakes", "recorded handshakes", results::handshakes),
    target("part", "results of shards, in JSON", results::part),
    target("arguments", "values of the command line's options", arguments),
];

const fn target(name: &'static str, format: &'static str, parse: fn(&[u8]) -> bool) -> Target {
    Target { name, format, parse }
}

fn transactions(bytes: &[u8]) -> bool {
    let half = Config::DEFAULT.format(Format::BINARY16).lanes(Lanes::Two);
    let read = |config: Config| {
        let mut model = raypath_sim::Datapath::paper(config).model();
        let mut is_any = false;
        for kind in model.kinds() {
            let jobs = read_from(bytes, Path::new("jobs.txt"), kind, &model, config).unwrap_or_default();
            jobs.iter().take(4).for_each(|Transaction { job, .. }| _ = model.run(job));
            is_any |= !jobs.is_empty();
        }
        is_any
    };
    [Config::DEFAULT, half].map(read).contains(&true)
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
    // A sweep with one value for each parameter is a configuration.
    if let [(_, config)] = configs.as_slice() {
        assert_eq!(parse(&as_toml(*config), Path::new("again.toml")).ok(), Some(*config));
    }
    true
}

/// The text of a configuration file.
fn as_toml(config: Config) -> String {
    parameters().map(|parameter| format!("{} = \"{}\"\n", parameter.name, parameter.get(&config))).collect()
}

fn earlier_report(bytes: &[u8]) -> bool {
    let Ok(baseline) = Baseline::parse(bytes, Path::new("ppa.json")) else { return false };
    assert!(baseline.area.total.is_finite() && baseline.slowest.ns.is_finite());
    baseline.stages.iter().all(|stage| baseline.stage(&stage.name).is_some())
}

/// Hits are written as they are read, and a picture of them is drawn or refused.
fn hits(bytes: &[u8]) -> bool {
    let read = |text: &[u8]| parse_hits(std::str::from_utf8(text).ok()?, Path::new("hits.txt")).ok();
    let write = |hits: &[Option<Hit>]| {
        let mut text = Vec::new();
        write_hits(&mut text, hits).map(|()| text).ok()
    };
    let Some(hits) = read(bytes) else { return false };
    // As text, because a NaN differs from itself.
    let text = write(&hits);
    assert_eq!(text.as_deref().and_then(read).as_deref().and_then(write), text);
    let drawn = &hits[..hits.len().min(64)];
    let size = (drawn.len() as u32, 1);
    let places = parse_instances("1 0 0 0 0 1 0 0 0 0 1 0\n-2 0 0 9 0 1 0 0 0 0 1 0", Path::new("places.txt"));
    let mesh = pyramid();
    let camera = mesh.as_ref().map(|mesh| Camera::framing(mesh, 1.0));
    let one = mesh.clone().and_then(|mesh| Scene::new(mesh).ok());
    let two = mesh.zip(places.ok()).and_then(|(mesh, places)| Scene::of_instances(mesh, &places, []).ok());
    if let (Some(camera), Some(one), Some(two)) = (camera, one, two) {
        for scene in [one, two] {
            let is_drawn = draw(&scene, &camera, size, drawn).is_ok();
            assert_eq!(is_drawn, hits_exist(&scene, drawn) && !drawn.is_empty(), "{drawn:?}");
        }
    }
    true
}

/// Whether the triangles and instances of hits are those of a scene.
fn hits_exist(scene: &Scene, hits: &[Option<Hit>]) -> bool {
    let (triangles, instances) = (scene.mesh().triangles().len(), scene.instances());
    hits.iter().flatten().all(|hit| {
        let number = hit.instance.map_or(0, |instance| instance as usize + 1);
        (hit.triangle as usize) < triangles && (number > 0) == (instances > 0) && number <= instances
    })
}

/// A scene of the instances is refused, or rays through it have hits in one of them.
fn instances(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    let Ok(places) = parse_instances(text, Path::new("places.txt")) else { return false };
    let places = &places[..places.len().min(16)];
    let Some(Ok(scene)) = pyramid().map(|mesh| Scene::of_instances(mesh, places, [])) else { return true };
    let mut tracer = Tracer::new(&scene, Tracing { two_sided: true, ..Tracing::default() });
    let bounds = scene.bounds();
    for corner in [bounds.min, bounds.max] {
        let towards = bounds.centre();
        let direction = std::array::from_fn(|axis| towards[axis] - corner[axis]);
        let Ok(ray) = Ray::new(corner, direction, f32::INFINITY) else { continue };
        if let Some(hit) = tracer.trace(&ray, Goal::Closest) {
            assert!(hits_exist(&scene, &[Some(hit)]) && hit.t >= 0.0 && hit.t.is_finite(), "{hit:?}");
        }
    }
    true
}

/// A mesh of four triangles.
fn pyramid() -> Option<Mesh> {
    let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    Mesh::new(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).ok()
}

/// Each line is parsed as the value of every option; a line of seven numbers is a ray.
fn arguments(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes);
    let mut is_valid = false;
    for line in text.lines().take(64) {
        is_valid |= round_trips::<Format>(line) | round_trips::<Shard>(line) | round_trips::<Rules>(line);
        is_valid |= round_trips::<Lanes>(line) | round_trips::<Encoding>(line) | round_trips::<Control>(line);
        is_valid |= round_trips::<Sharing>(line) | round_trips::<UnitLatency>(line) | round_trips::<Preset>(line);
        is_valid |= round_trips::<UnitSharing>(line) | round_trips::<Interval>(line);
        is_valid |= round_trips::<Multiplier>(line) | round_trips::<JobKind>(line) | line.parse::<Level>().is_ok();
        if let Ok(shard) = line.parse::<Shard>() {
            assert!(shard.share(u64::MAX) >= 1 || shard.number() == u64::MAX);
        }
        let numbers: Vec<f32> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        if let &[x, y, z, u, v, w, extent] = numbers.as_slice() {
            let ray: Result<Ray<raypath_ops::Binary32>, _> = Ray::new([x, y, z], [u, v, w], extent);
            is_valid |= ray.is_ok();
        }
    }
    is_valid
}

/// Parses a value, and checks that it prints as a text with the same value.
fn round_trips<T: FromStr + Display + PartialEq>(text: &str) -> bool {
    let Ok(value) = text.parse::<T>() else { return false };
    assert!(value.to_string().parse::<T>().is_ok_and(|again| again == value), "{text:?} prints as '{value}'");
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::fs;

    /// Reads every file of the corpora, its halves, and copies with one byte changed: no panic, and each corpus has a
    /// valid file, so that more than the first checks of a reader run.
    #[test]
    fn corpora_are_read() {
        let corpora = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
        let folders: BTreeSet<String> = names(&corpora).collect();
        let expected = TARGETS.iter().map(|target| target.name.to_string()).chain(["c_interface".to_string()]);
        assert_eq!(folders, expected.collect());
        for target in TARGETS {
            let folder = corpora.join(target.name);
            let files: Vec<Vec<u8>> = names(&folder).map(|name| fs::read(folder.join(name)).expect("a file")).collect();
            assert!(files.iter().any(|bytes| (target.parse)(bytes)), "{} has no valid file", target.name);
            for (number, bytes) in files.iter().enumerate().filter(|(_, bytes)| !bytes.is_empty()) {
                let half = bytes.len() / 2;
                (target.parse)(&bytes[..half]);
                (target.parse)(&bytes[half..]);
                let mut changed = bytes.clone();
                changed[(number * 7919 + 13) % bytes.len()] ^= 1 << (number % 8);
                (target.parse)(&changed);
            }
        }
    }

    fn names(folder: &Path) -> impl Iterator<Item = String> {
        let entries = fs::read_dir(folder).expect("a folder");
        entries.map(|entry| entry.expect("an entry").file_name().into_string().expect("a name"))
    }
}
