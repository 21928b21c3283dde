//! The ports of jobs and outcomes: names as in `docs/integration/ports.md`, and values without loss of bits.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_ops::{Job, JobKind, Outcome, PortKind};
use std::collections::BTreeMap;

/// The names of the input ports in `docs/integration/ports.md`.
fn inputs(kind: JobKind) -> Vec<String> {
    let on = |stem: &str, axes: &str| axes.chars().map(|axis| format!("{stem}_{axis}")).collect::<Vec<_>>();
    let ray = || {
        let vectors = ["ray_origin", "ray_dir", "ray_inv", "ray_shear"].into_iter().flat_map(|v| on(v, "xyz"));
        vectors.chain(["ray_extent", "ray_kx", "ray_ky", "ray_kz"].map(String::from)).collect::<Vec<_>>()
    };
    let beat = |lanes: usize| {
        let vectors = ["a", "b"].into_iter().flat_map(|v| (0..lanes).map(move |i| format!("euclidean_{v}_{i}")));
        vectors.chain(["euclidean_mask", "euclidean_reset_accum"].map(String::from)).collect::<Vec<_>>()
    };
    let mut names = match kind {
        JobKind::Triangle => {
            [ray(), ["a", "b", "c"].iter().flat_map(|v| on(&format!("triangle_{v}"), "xyz")).collect()].concat()
        }
        JobKind::Quadbox => {
            let bounds = (0..4).flat_map(|i| on(&format!("aabb_{i}"), "xyz"));
            [ray(), bounds.flat_map(|b| [format!("{b}_min"), format!("{b}_max")]).collect()].concat()
        }
        JobKind::Euclidean => beat(16),
        JobKind::Angular => beat(8),
    };
    names.sort();
    names
}

/// The names of the output ports, sorted.
fn outputs(kind: JobKind) -> &'static str {
    match kind {
        JobKind::Triangle => "t_denom t_num triangle_hit",
        JobKind::Quadbox => "box_index_0 box_index_1 box_index_2 box_index_3 is_intersect tmin_0 tmin_1 tmin_2 tmin_3",
        JobKind::Euclidean => "euclidean_accumulator euclidean_reset_accum",
        JobKind::Angular => "angular_dot_product angular_norm angular_reset_accum",
    }
}

#[test]
fn ports_have_the_documented_names() {
    for kind in JobKind::ALL {
        let job: Job = Job::from_ports(kind, |_| 0);
        let mut names: Vec<String> = job.ports().into_iter().map(|port| port.name).collect();
        names.sort();
        assert_eq!(names, inputs(kind), "{kind}");
        let mut names: Vec<String> =
            Outcome::from_ports(kind, |_| 0).ports().into_iter().map(|port| port.name).collect();
        names.sort();
        assert_eq!(names.join(" "), outputs(kind), "{kind}");
    }
}

#[test]
fn opcodes_are_those_of_the_paper() {
    let opcodes = JobKind::ALL.map(|kind| (kind.name(), kind.opcode()));
    assert_eq!(opcodes, [("triangle", 0), ("quadbox", 1), ("euclidean", 2), ("angular", 3)]);
}

/// The width of a port in bits.
fn width(name: &str, kind: PortKind, job: JobKind) -> u32 {
    match (kind, name) {
        (PortKind::Number, _) => 32,
        (PortKind::Word, _) => 2,
        (_, "euclidean_mask") if job == JobKind::Euclidean => 16,
        (_, "euclidean_mask") => 8,
        (_, "is_intersect") => 4,
        _ => 1,
    }
}

/// All bits of port values are kept, including the payloads of NaNs of jobs. NaNs of outcomes become canonical.
#[test]
fn every_bit_survives() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for kind in JobKind::ALL {
        for _ in 0..500 {
            let mut given = BTreeMap::new();
            let mut draw = |name: &str| {
                *given.entry(name.to_string()).or_insert_with(|| match rng.random_range(0..4) {
                    0 => 0x7f80_0001 | rng.random::<u64>() & 0x807f_ffff,
                    _ => rng.random::<u64>(),
                })
            };
            let job: Job = Job::from_ports(kind, &mut draw);
            let outcome = Outcome::from_ports(kind, &mut draw);
            assert_eq!((job.kind(), outcome.kind()), (kind, kind));
            for port in job.ports() {
                let mask = u64::MAX >> (64 - width(&port.name, port.kind, kind));
                assert_eq!(port.bits, given[&port.name] & mask, "{}", port.name);
            }
            for port in outcome.ports() {
                let bits = given[&port.name] & (u64::MAX >> (64 - width(&port.name, port.kind, kind)));
                let is_nan = port.kind == PortKind::Number && bits & 0x7fff_ffff > 0x7f80_0000;
                assert_eq!(port.bits, if is_nan { 0x7fc0_0000 } else { bits }, "{}", port.name);
            }
        }
    }
}
