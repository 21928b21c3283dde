//! The cluster in Verilator does in each cycle what the model does.

use super::{Beat, CacheParameters, Cluster, Moved, SystemParameters};
use crate::engine::BlockRequest;
use crate::traffic::{BlockScene, random_ray};
use crate::{Memory, RayRequest, Unit, UnitNetlist, UnitOutputs, UnitParameters, UnitPorts};
use rand::rngs::ChaCha8Rng;
use rand::{Rng, RngExt, SeedableRng};
use raypath_hdl::{Builder, Module, verilog};
use raypath_ops::Rules;
use raypath_rtl::Config;
use raypath_tools::{Options, Sources, Verilated, lint_slang, lint_verilator, lint_yosys};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;

const UNITS: u32 = 2;
const CONTEXTS: u32 = 8;
const WIDTH: u32 = 256;
const BLOCK: u32 = 128;
const RAYS: usize = 100;

#[test]
fn a_cluster_is_that_of_the_model_in_every_cycle() {
    let cache = CacheParameters { sets: 4, ways: 2, line: 2 * BLOCK, misses: 4 };
    let parameters =
        UnitParameters { contexts: CONTEXTS, memory_width: WIDTH, id_width: 9, ..UnitParameters::default() };
    let unit = UnitNetlist::new(Config::DEFAULT, parameters).expect("a unit");
    // The text is that of another unit, with parameters for this one.
    let greater = UnitParameters { contexts: 2 * CONTEXTS - 1, id_width: 12, ..parameters };
    let emitted = UnitNetlist::new(Config::DEFAULT, greater).expect("a unit").cluster().expect("a cluster");
    let folder = tempfile::tempdir().expect("a folder");
    let mut sources = Sources::write(&emitted, folder.path()).expect("sources");
    let (shell, text) = bench(&unit.cluster().expect("a cluster"), cache);
    sources.add(folder.path().join("bench.sv"), &text).expect("the bench");
    lint_verilator(&sources.files, "bench", &[]).expect("no report of Verilator");
    let all = folder.path().join("all.sv");
    let texts = sources.files.iter().map(|file| std::fs::read_to_string(file).expect("a text"));
    std::fs::write(&all, texts.collect::<String>()).expect("a file");
    lint_yosys(&all, "bench").expect("no report of Yosys");
    lint_slang(&[all]).expect("no report of slang");
    let verilated =
        Verilated::build_sources(&sources.files, &shell, folder.path(), &Options::default()).expect("a build");
    let (frames, expected) = traffic(&unit, &shell, cache);
    let ports = UnitPorts::of(&unit.top);
    let mut seen = 0;
    verilated
        .run_randomly(5, frames, |cycle, found| {
            let Expected { offers, moved: Moved { enters, hit, request } } = &expected[cycle];
            let outputs: UnitOutputs = ports.outputs(found);
            assert_eq!((&outputs.hit, &outputs.request), (hit, request), "cycle {cycle}");
            assert!(!offers || outputs.ray_ready == *enters, "cycle {cycle}: a ray enters is {enters}");
            seen += 1;
        })
        .expect("a run");
    assert_eq!(seen, expected.len());
}

/// A module with fixed widths around a cluster, and its text.
fn bench(cluster: &Module, CacheParameters { sets, ways, line, misses }: CacheParameters) -> (Arc<Module>, String) {
    let m = Builder::new("bench");
    let width = |name: &str, width| match name {
        "mem_req_tag_o" | "mem_rsp_tag_i" => (UNITS * misses).trailing_zeros(),
        count if count.starts_with("count_") => UNITS,
        _ => width,
    };
    cluster.inputs().iter().for_each(|port| {
        m.input(&port.name, width(&port.name, cluster.signal(port.signal).width));
    });
    // For its clock and reset.
    let state = m.register("state_q", 1).reset_to(0);
    state.next(state.wire());
    for port in cluster.outputs() {
        m.output(&port.name, m.constant(width(&port.name, cluster.signal(port.signal).width), 0));
    }
    let shell = m.finish().expect("a module");
    let printed = verilog::print_module(&shell, &[]).expect("a text");
    let mut text = printed.split_once(");\n").map(|(ports, _)| format!("{ports});\n")).expect("ports");
    let words = (0..WIDTH / 32).rev().map(|word| format!("mem_rsp_data_{word}_i")).collect::<Vec<_>>().join(", ");
    writeln!(
        text,
        "  raypath_cluster #(.Contexts ({CONTEXTS}), .IdWidth (9), .Units ({UNITS}), .CacheSets ({sets}), \
         .CacheWays ({ways}), .CacheMisses ({misses}), .CacheLineBytes ({line})) u_cluster (.mem_rsp_data_i ({{{words}}}), .*);\nendmodule"
    )
    .expect("a text");
    (shell, text)
}

/// What the model says of a cycle, in which a ray may be offered.
struct Expected {
    offers: bool,
    moved: Moved,
}

/// A request in the memory: its address, its beats that have arrived, and when the next one may.
struct Line {
    address: u64,
    beats: u32,
    due: usize,
}

/// Random rays, stalls and responses in any order: the frames, and what is expected.
fn traffic(unit: &UnitNetlist, shell: &Module, cache: CacheParameters) -> (Vec<Vec<u64>>, Vec<Expected>) {
    let parameters = unit.parameters;
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let (scene, root) = BlockScene::random(150, &mut random);
    let scene = &scene.0[..];
    let rays: Vec<RayRequest> = (0..RAYS).map(|_| random_ray(root, &mut random)).collect();
    let system = SystemParameters { units: UNITS, cache: Some(cache), ..SystemParameters::of_latency(1) };
    let mut cluster = Cluster::new(&unit.shape(), parameters, scene, &system);
    let mut lines: BTreeMap<u32, Line> = BTreeMap::new();
    let line_bytes = system.request_bytes(parameters);
    let (mut frames, mut expected) = (Vec::new(), Vec::new());
    let (mut next, mut replies) = (0, BTreeMap::new());
    let mut offered = None;
    while replies.len() < RAYS {
        let now = expected.len();
        if offered.is_none() && next < RAYS && random.random_range(0..40) < [1, 40][now / 300 % 2] {
            offered = Some((next as u64, rays[next]));
            next += 1;
        }
        let [hit_ready, request_ready] = [(); 2].map(|()| random.random_range(0..8) < [8, 3][now / 100 % 2]);
        let due: Vec<u32> = lines.iter().filter(|(_, line)| line.due <= now).map(|(tag, _)| *tag).collect();
        let tag = (!due.is_empty()).then(|| due[random.random_range(0..due.len())]);
        let beat = tag.map(|tag| Beat { tag, is_error: scene.block(lines[&tag].address, BLOCK).is_err() });
        let arrives = beat.map(|Beat { tag, is_error }| {
            let line = lines.get_mut(&tag).expect("a line");
            let address = line.address + u64::from(line.beats * WIDTH / 8);
            line.beats += 1;
            let bytes = scene.block(address, WIDTH / 8).map_or(vec![0; WIDTH as usize / 8], <[u8]>::to_vec);
            (tag, is_error, bytes)
        });
        if let Some(tag) = tag.filter(|tag| lines[tag].beats * WIDTH / 8 == line_bytes) {
            lines.remove(&tag);
        }
        let word = |name: &str| -> Option<u64> {
            let (data, (tag, error)) = arrives.as_ref().map_or((None, (None, None)), |(tag, is_error, bytes)| {
                let number =
                    name.strip_prefix("mem_rsp_data_").and_then(|word| word.trim_end_matches("_i").parse().ok());
                let chunk = number.and_then(|number: usize| bytes.as_chunks().0.get(number));
                (chunk.map(|bytes| u32::from_le_bytes(*bytes)), (Some(*tag), Some(*is_error)))
            });
            let ray = offered.as_ref();
            let number = |value: f32| u64::from(value.to_bits());
            let of_ray = |read: &dyn Fn(&(u64, RayRequest)) -> u64| ray.map(read);
            match name {
                "flush_i" | "invalidate_i" => Some(0),
                "node_limit_i" => Some(parameters.step.node_limit.into()),
                "ray_valid_i" => Some(ray.is_some().into()),
                "ray_id_i" => of_ray(&|(id, _)| *id),
                "ray_flags_i" => of_ray(&|(_, ray)| ray.flags.into()),
                "ray_root_i" => of_ray(&|(_, ray)| ray.root.into()),
                "ray_tmin_i" => of_ray(&|(_, ray)| number(ray.t_min)),
                "ray_tmax_i" => of_ray(&|(_, ray)| number(ray.t_max)),
                "hit_ready_i" => Some(hit_ready.into()),
                "mem_req_ready_i" => Some(request_ready.into()),
                "mem_rsp_valid_i" => Some(beat.is_some().into()),
                "mem_rsp_tag_i" => tag.map(u64::from),
                "mem_rsp_error_i" => error.map(u64::from),
                _ if name.starts_with("ray_") => {
                    let axis = ["_x_i", "_y_i", "_z_i"].iter().position(|end| name.ends_with(end)).expect("an axis");
                    of_ray(&|(_, ray)| number(if name.contains("dir") { ray.direction } else { ray.origin }[axis]))
                }
                _ => data.map(u64::from),
            }
        };
        let inputs: Vec<(u32, Option<u64>)> =
            shell.inputs().iter().map(|port| (shell.signal(port.signal).width, word(&port.name))).collect();
        let words = inputs.into_iter().map(|(width, word)| word.unwrap_or_else(|| random.next_u64() >> (64 - width)));
        frames.push([1].into_iter().chain(words).collect());
        let moved = cluster.cycle(offered.as_ref(), beat, hit_ready, request_ready);
        if let Some(BlockRequest { address, tag }) = moved.request.filter(|_| request_ready) {
            let due = now + 1 + random.random_range(0..[1, 60][now / 200 % 2]);
            assert!(lines.insert(tag, Line { address, beats: 0, due }).is_none(), "tag {tag} is in use");
        }
        if let Some((number, reply)) = moved.hit.filter(|_| hit_ready) {
            replies.insert(number, reply);
        }
        let offers = offered.is_some();
        if moved.enters {
            offered = None;
        }
        expected.push(Expected { offers, moved });
    }
    let mut functional = Unit::new(Rules::Paper, parameters.step);
    assert!(rays.iter().zip(replies.values()).all(|(ray, reply)| functional.trace(scene, ray) == *reply));
    (frames, expected)
}
