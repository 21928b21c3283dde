//! The simulated netlist of the unit returns what the functional model does, whatever the memory and the users of the
//! other channels do. The item `unit` of `raypath verify` does the same for more units, scenes and rays.

use crate::common::along_z;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_hdl::{Builder, Module, mutate};
use raypath_model::Shape;
use raypath_ops::{Rounding, Rules};
use raypath_rtl::{Config, Control};
use raypath_tools::{Options, Sources, Verilated};
use raypath_traversal::blocks::NodeKind::{Quantised, Wide4, Wide8};
use raypath_traversal::state::status;
use raypath_traversal::traffic::{
    Behaviour, BlockScene, Environment, ProtocolError, RecordedCycle, RecordedEngine, TwoLevelScene, random_ray,
    verdict_of,
};
use raypath_traversal::{
    Front, Memory, MemoryError, NODE_LIMIT, NetlistEngine, Queries, RayRequest, Reply, StepParameters, Unit,
    UnitEngine, UnitFeatures, UnitInputs, UnitModel, UnitNetlist, UnitParameters, UnitPorts,
};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

const NOTHING: UnitFeatures = UnitFeatures::OFF;
const WEIGHTS: UnitFeatures = UnitFeatures { barycentrics: true, ..UnitFeatures::OFF };
const FLAGS: UnitFeatures = UnitFeatures { queries: Queries::Flags, ..NOTHING };
const CANDIDATES: UnitFeatures = UnitFeatures { queries: Queries::Full, ..NOTHING };
const EVERYTHING: UnitFeatures = UnitFeatures::ALL;
const QUIET: Behaviour = Behaviour { latency: (1, 20), stalls: [0; 4], errors: 0 };
const SLOW: Behaviour = Behaviour { latency: (1, 500), stalls: [64; 4], errors: 200 };
const BLOCKED: Behaviour = Behaviour { latency: (1, 30), stalls: [10, 240, 200, 100], errors: 0 };

/// A random scene for a unit, with instances if it has them, some of which no ray can enter; and rays.
fn setting(step: StepParameters, count: usize, seed: u64) -> (BlockScene, Vec<RayRequest>) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (mut scene, mut root) = if step.features.instances {
        let TwoLevelScene { blocks, root, .. } = TwoLevelScene::random(step.node, 20, true, &mut random);
        (blocks, root)
    } else {
        BlockScene::random_of(step.node, 250, &mut random)
    };
    root = scene.give_geometries(root, step.features.queries, &mut random);
    (scene, (0..count).map(|_| random_ray(root, &mut random)).collect())
}

/// The models of the unit round every sum: other hardware would have other hits.
#[test]
fn sums_that_round_once_are_refused() {
    let config = Config::DEFAULT.rounding(Rounding::Sum);
    let problem = UnitNetlist::new(config, UnitParameters::default()).map(|_| ()).expect_err("refused").to_string();
    assert_eq!(problem, "the unit has no datapath with rounding sum, expected rounding unit");
}

/// The cycle-exact model and the netlist, in lockstep, under every behaviour of the other channels. Without errors of
/// the memory, the replies are those of the functional model.
#[test]
fn the_model_equals_the_netlist_in_every_cycle() {
    let (mut entered, mut failed) = (0, 0);
    // Contexts, stack, nodes, features, width of the memory, of ids, latency of division; latency of the memories of a
    // step. The first has more rays than ids.
    for (seed, (contexts, stack, node, features, memory_width, id_width, divider_latency), ram_latency, control) in [
        (1, (8, 8, Wide4, NOTHING, 128, 3, 1), 1, Control::Skid),
        (2, (12, 2, Wide4, CANDIDATES, 512, 64, 11), 2, Control::Credit),
        (3, (64, 8, Wide4, WEIGHTS, 1024, 16, 27), 1, Control::Skid),
        (
            4,
            (9, 8, Quantised, UnitFeatures { barycentrics: true, instances: true, ..FLAGS }, 128, 16, 4),
            2,
            Control::Credit,
        ),
        (5, (64, 4, Quantised, UnitFeatures { barycentrics: false, ..EVERYTHING }, 512, 16, 27), 1, Control::Skid),
        (
            6,
            (8, 2, Wide4, UnitFeatures { queries: Queries::None, nested: false, ..EVERYTHING }, 128, 16, 1),
            2,
            Control::Credit,
        ),
        (7, (64, 8, Wide4, EVERYTHING, 1024, 16, 11), 1, Control::Skid),
        (8, (12, 2, Wide8, NOTHING, 256, 64, 11), 2, Control::Credit),
        (9, (64, 4, Wide8, EVERYTHING, 1024, 16, 4), 2, Control::Skid),
        (10, (9, 4, Wide4, UnitFeatures { instances: true, ..CANDIDATES }, 256, 16, 4), 1, Control::Credit),
    ] {
        let front = [Front::CounterClockwise, Front::Clockwise][seed as usize % 2];
        let node_limit = [NODE_LIMIT, 6, 0][seed as usize % 3];
        let step = StepParameters { stack, node, front, node_limit, features };
        let parameters = UnitParameters {
            contexts,
            step,
            memory_width,
            id_width,
            divider_latency,
            ram_latency,
            parity: seed % 4 > 1,
            ..UnitParameters::default()
        };
        let unit = UnitNetlist::new(Config::DEFAULT.control(control), parameters).expect("a unit");
        let (scene, rays) = setting(step, 150, seed);
        for behaviour in [QUIET, SLOW, BLOCKED] {
            let (mut netlist, mut model) = (NetlistEngine::new(&unit).expect("a simulation"), UnitModel::of(&unit));
            let mut environment = Environment::new(&scene.0, parameters, rays.clone(), behaviour, seed);
            while !environment.is_done() {
                // Where replies are not compared, rays may be lost.
                if behaviour == SLOW && environment.cycles() % 700 == 699 {
                    environment.flush();
                }
                environment
                    .cycle(&mut [&mut netlist, &mut model])
                    .unwrap_or_else(|problem| panic!("{parameters}: {problem:?}"));
                assert!(environment.cycles() < 1_000_000, "{} rays ended", environment.replies.len());
            }
            entered += model.counts().transforms / 2;
            if behaviour.errors == 0 {
                let mut functional = Unit::new(Rules::Paper, step);
                let expected: Vec<Reply> =
                    rays.iter().map(|ray| functional.trace_with(&scene.0[..], ray, &mut verdict_of)).collect();
                let replies: Vec<Reply> = environment.replies.values().copied().collect();
                failed += replies.iter().filter(|reply| reply.status >= status::MEMORY).count();
                assert_eq!(replies, expected, "{parameters}");
            }
        }
    }
    assert!(entered > 500 && failed > 20, "{entered} instances were entered, {failed} rays failed");
}

/// A column of one bit that is always 0 in a memory is a wrong bit of some words. With parity, each ray ends with its
/// hit or with an error of the memory; without, some have a wrong hit.
#[test]
fn parity_ends_rays_that_read_a_wrong_bit() {
    let of_walk = ["u_states.", "u_stack.", "u_outcomes.", "u_verdicts.", "u_candidates."].map(|name| ("u_walk", name));
    let memories: Vec<_> = [("u_rays", "u_begins."), ("u_blocks", "u_children_")].into_iter().chain(of_walk).collect();
    for (node, features, memories) in [(Wide4, NOTHING, &memories[..5]), (Quantised, EVERYTHING, &memories[..])] {
        let step = StepParameters { stack: 4, node, features, ..StepParameters::default() };
        let (scene, rays) = setting(step, 60, 11);
        let mut functional = Unit::new(Rules::Paper, step);
        let expected: Vec<Reply> =
            rays.iter().map(|ray| functional.trace_with(&scene.0[..], ray, &mut verdict_of)).collect();
        let mut wrong = 0;
        for (parity, (part, memory)) in
            [false, true].into_iter().flat_map(|parity| memories.iter().map(move |of| (parity, *of)))
        {
            let parameters = UnitParameters { contexts: 8, step, parity, ram_latency: 2, ..UnitParameters::default() };
            let mut unit = UnitNetlist::new(Config::DEFAULT, parameters).expect("a unit");
            let top = unit.top.clone();
            let part = &top.instances().iter().find(|instance| instance.name == part).expect("a part").module;
            let mut errors = 0;
            for fault in mutate::faults(part).iter().filter(|fault| is_lost_bit(part, memory, &fault.to_string())) {
                unit.top = mutate::replace(&top, &Arc::new(fault.apply(part).expect("a fault"))).expect("a unit");
                let mut netlist = NetlistEngine::new(&unit).expect("a simulation");
                let mut environment = Environment::new(&scene.0, parameters, rays.clone(), QUIET, 1);
                let mut proceeds = true;
                while proceeds && !environment.is_done() && environment.cycles() < 20_000 {
                    proceeds = environment.cycle(&mut [&mut netlist]).is_ok();
                }
                let others =
                    environment.replies.iter().filter(|(number, reply)| **reply != expected[**number as usize]);
                let (failed, hits): (Vec<_>, Vec<_>) = others.partition(|(_, reply)| reply.status == status::MEMORY);
                errors += failed.len();
                wrong += if parity { 0 } else { hits.len() };
                let is_right = hits.is_empty() && environment.replies.len() == rays.len();
                assert!(is_right || !parity, "{fault}: {} wrong hits", hits.len());
            }
            assert!(errors > 0 || !parity, "{memory}: no error");
        }
        assert!(wrong > 20, "{wrong} wrong hits without parity");
    }
}

/// Whether a fault is the loss of a column of one bit of this memory.
fn is_lost_bit(part: &Module, memory: &str, fault: &str) -> bool {
    let columns =
        part.memories().iter().filter(|known| format!("{}.", known.name).starts_with(memory)).flat_map(|known| {
            let bits = known.columns.iter().filter(|column| part.signal(column.read).width == 1);
            bits.map(|column| format!(" {}.write_{}: replaced by zero", known.name, column.name))
        });
    columns.into_iter().any(|text| fault.ends_with(&text))
}

/// Scenes, each in the window of addresses that a base selects.
struct Windows(Vec<(u32, BlockScene)>);

impl Memory for Windows {
    fn block(&self, address: u64, bytes: u32) -> Result<&[u8], MemoryError> {
        let (base, lower) = (address >> 32, address & u64::from(u32::MAX));
        let window = self.0.iter().find(|(known, _)| u64::from(*known) == base).ok_or(MemoryError(address))?;
        window.1.0[..].block(lower, bytes)
    }
}

/// Rays of different bases, which are inside at the same time, read different scenes. A window without a scene is an
/// error of the memory.
#[test]
fn each_ray_reads_the_window_of_its_base() {
    for (address_width, node, features) in
        [(33, Wide4, NOTHING), (40, Quantised, FLAGS), (64, Wide4, EVERYTHING), (64, Quantised, NOTHING)]
    {
        let step = StepParameters { node, features, ..StepParameters::default() };
        let parameters = UnitParameters { contexts: 24, step, address_width, ..UnitParameters::default() };
        let unit = UnitNetlist::new(Config::DEFAULT, parameters).expect("a unit");
        let width = |port: &str| unit.top.port_width(port);
        assert_eq!((width("mem_req_addr_o"), width("ray_base_i")), (Some(address_width), Some(address_width - 32)));
        let greatest = parameters.greatest_base();
        let (mut windows, mut rays) = (Windows(Vec::new()), Vec::new());
        for (seed, base) in [0, greatest, greatest / 2 + 1, greatest / 3].into_iter().enumerate() {
            let (scene, of_scene) = setting(step, 40, seed as u64);
            rays.push(of_scene.into_iter().map(|ray| RayRequest { base, ..ray }).collect::<Vec<_>>());
            if windows.0.iter().all(|(known, _)| *known != base) && base != greatest / 3 {
                windows.0.push((base, scene));
            }
        }
        let rays: Vec<RayRequest> = (0..40).flat_map(|place| rays.iter().map(move |rays| rays[place])).collect();
        let (mut netlist, mut model) = (NetlistEngine::new(&unit).expect("a simulation"), UnitModel::of(&unit));
        let mut environment = Environment::with_memory(&windows, parameters, rays.clone(), QUIET, 1);
        while !environment.is_done() {
            let checked = environment.cycle(&mut [&mut netlist, &mut model]);
            checked.unwrap_or_else(|problem| panic!("{parameters}: {problem:?}"));
            assert!(environment.cycles() < 100_000, "{} rays ended", environment.replies.len());
        }
        let mut functional = Unit::new(Rules::Paper, step);
        let mut trace = |ray: &RayRequest| functional.trace_with(&windows, ray, &mut verdict_of);
        let expected: Vec<Reply> = rays.iter().map(&mut trace).collect();
        assert!(environment.replies.values().eq(&expected), "{parameters}");
        let changed = |ray: &RayRequest| trace(&RayRequest { base: greatest - ray.base, ..*ray });
        assert_ne!(rays.iter().map(changed).collect::<Vec<_>>(), expected);
    }
}

/// A slice has the addresses from 0 on, and those beyond are not taken for others.
#[test]
fn a_slice_has_no_window_but_the_first() {
    let bytes = [7; 128];
    assert_eq!(bytes[..].block(0, 128), Ok(&bytes[..]));
    for address in [1 << 32, u64::MAX - 127, 64] {
        assert_eq!(bytes[..].block(address, 128), Err(MemoryError(address)));
    }
}

/// While no hit is taken, a unit accepts a ray for each context, and one more: a hit at the port has given its context
/// back.
#[test]
fn a_unit_accepts_one_ray_more_than_it_has_contexts() {
    for (contexts, features) in [(8, UnitFeatures::OFF), (11, EVERYTHING)] {
        let step = StepParameters { features, ..StepParameters::default() };
        let parameters = UnitParameters { contexts, step, ..UnitParameters::default() };
        let unit = UnitNetlist::new(Config::DEFAULT, parameters).expect("a unit");
        let (mut netlist, mut model) = (NetlistEngine::new(&unit).expect("a simulation"), UnitModel::of(&unit));
        let mut accepted = 0;
        for _ in 0..500 {
            let outputs = netlist.outputs();
            assert_eq!(outputs, model.outputs());
            accepted += u32::from(outputs.ray_ready);
            // The root is missing, so that a ray ends without a request.
            let ray = Some((u64::from(accepted), along_z(0)));
            let inputs = UnitInputs { ray, ..UnitInputs::default() };
            netlist.cycle(&inputs);
            model.cycle(&inputs);
        }
        assert_eq!(accepted, contexts + 1);
    }
}

/// A reset under a memory that goes on is safe while a flush keeps the unit idle. Otherwise beats of requests from
/// before the reset are taken for those of later ones.
#[test]
fn a_reset_is_safe_after_a_flush() {
    let parameters = UnitParameters { contexts: 16, ..UnitParameters::default() };
    let (scene, rays) = setting(parameters.step, 100, 5);
    let mut functional = Unit::new(Rules::Paper, parameters.step);
    let run = |flushes_first: bool| -> Result<BTreeMap<u64, Reply>, ProtocolError> {
        let mut model = UnitModel::new(&Shape::default(), parameters);
        let mut environment = Environment::new(&scene.0, parameters, rays.clone(), QUIET, 7);
        while !environment.is_done() {
            match environment.cycles() {
                100..200 if flushes_first => environment.flush(),
                200 => environment.reset(&mut [&mut model], false),
                _ => {}
            }
            environment.cycle(&mut [&mut model])?;
        }
        Ok(environment.replies)
    };
    let replies = run(true).expect("the protocol");
    assert!((50..100).contains(&replies.len()), "{} rays ended", replies.len());
    for (number, reply) in replies {
        assert_eq!(reply, functional.trace(&scene.0[..], &rays[number as usize]));
    }
    let broken = run(false).expect_err("the memory owed beats");
    assert!(broken.to_string().contains("answers owed"), "{broken}");
}

/// The frames that drove the model, with two resets and two flushes while rays are inside, drive Verilator, which
/// begins with random values in registers and memories and without a reset. No assertion fails, and the linters have
/// nothing to say.
#[test]
fn verilator_equals_the_model_in_every_cycle() {
    verilator_equals_the_model(StepParameters { features: EVERYTHING, ..StepParameters::default() });
}

/// Cycles of resets and of flushes.
const RESETS: [usize; 2] = [300, 900];
const FLUSHES: [usize; 2] = [600, 1200];

fn verilator_equals_the_model(step: StepParameters) {
    let parameters = UnitParameters {
        contexts: 8,
        memory_width: 256,
        ram_latency: 2,
        parity: true,
        step,
        ..UnitParameters::default()
    };
    let (scene, rays) = setting(step, 60, 3);
    let unit = UnitNetlist::new(Config::DEFAULT, parameters).expect("a unit");
    let folder = tempfile::tempdir().expect("a folder");
    let mut sources = Sources::write(&unit.emitted().expect("a text"), folder.path()).expect("sources");
    sources.lint().expect("no report of the linters");
    // The wrapper with structures is around the unit.
    for (path, text) in unit.files(raypath_rtl::package::PERIOD_NS).expect("files") {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        if name == "raypath_properties.sv" || (name.contains("_wrapper") && name.ends_with(".sv")) {
            sources.add(folder.path().join(name), &text).expect("the assertions, the wrapper and its package");
        }
    }
    let (flat, text) = flattened(&unit.top);
    sources.add(folder.path().join("flat.sv"), &text).expect("the ports of the unit");
    let options = Options::default();
    let verilated = Verilated::build_sources(&sources.files, &flat, folder.path(), &options).expect("a build");
    let ports = UnitPorts::of(&unit.top);
    let mut recorded = RecordedEngine::new(UnitModel::of(&unit), &unit.top);
    let mut environment = Environment::new(&scene.0, parameters, rays, QUIET, 2);
    while !environment.is_done() {
        if RESETS.contains(&recorded.cycles.len()) {
            environment.reset(&mut [&mut recorded], true);
        }
        if FLUSHES.contains(&recorded.cycles.len()) {
            environment.flush();
        }
        environment.cycle(&mut [&mut recorded]).expect("the protocol");
    }
    // Before the first reset everything is unknown, as are the inputs.
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let words = recorded.cycles[0].frame.len() - 1;
    let before = (0..20).map(|cycle| {
        let frame = [u64::from(cycle < 17)].into_iter().chain((0..words).map(|_| random.random())).collect();
        RecordedCycle { frame, outputs: None }
    });
    let cycles = before.chain(recorded.cycles).map(|cycle| (cycle.frame, cycle.outputs));
    let (frames, outputs): (Vec<_>, Vec<_>) = cycles.unzip();
    let mut seen = 0;
    verilated
        .run_from_power_up(1, frames, |cycle, found| {
            // In a reset no output is expected.
            if let Some(expected) = &outputs[cycle] {
                assert_eq!(ports.outputs(found), *expected, "cycle {cycle}");
            }
            seen += 1;
        })
        .expect("a run");
    assert_eq!(seen, outputs.len());
}

/// A module with the ports of the unit around the wrapper with structures: for the test bench, and as text, which has
/// the field of each port.
fn flattened(top: &Module) -> (Arc<Module>, String) {
    let structures = "ray_t ray_i,hit_t hit_o,candidate_t cand_o,answer_t answer_i,mem_req_t mem_req_o,\
                      mem_rsp_t mem_rsp_i,count_t count_o";
    let field = |port: &str| {
        let of = |whole: &'static str| Some((whole, port.strip_prefix(&whole[..whole.len() - 1])?));
        let (whole, field) = structures.split([',', ' ']).skip(1).step_by(2).find_map(of)?;
        let field = &field[..field.len() - 2];
        Some(match field.split_once('_') {
            _ if ["valid", "ready"].contains(&field) => return None,
            _ if ["primitive", "instance", "end"].contains(&field) => {
                format!("{whole}.{}{field}", &whole[..whole.len() - 1])
            }
            Some((vector @ ("origin" | "dir"), axis)) => format!("{whole}.{vector}.{axis}"),
            Some(("data", word)) => format!("{whole}.data[32 * {word} +: 32]"),
            _ => format!("{whole}.{field}"),
        })
    };
    let m = Builder::new("flat");
    let clocked = m.register("clocked_q", 1).reset_to(0);
    clocked.next(clocked.wire());
    let mut ports = "input logic clk_i, input logic rst_ni".to_string();
    let declare = |structure| format!("raypath_unit_wrapper_pkg::{structure};\n");
    let mut wires: String = structures.split(',').map(declare).collect();
    for (name, width) in top.inputs().iter().map(|port| (&port.name, top.signal(port.signal).width)) {
        ports += &format!(", input logic [{}:0] {name}", width - 1);
        m.unused(&format!("unused_{name}"), &[m.input(name, width)]);
        wires.extend(field(name).map(|field| format!("assign {field} = {name};\n")));
    }
    for (name, width) in top.outputs().iter().map(|port| (&port.name, top.signal(port.signal).width)) {
        ports += &format!(", output logic [{}:0] {name}", width - 1);
        m.output(name, m.constant(width, 0));
        wires.extend(field(name).map(|field| format!("assign {name} = {field};\n")));
    }
    let text = format!("module flat ({ports});\n{wires}raypath_unit_wrapper u_wrapper (.*);\nendmodule\n");
    (m.finish().expect("a module"), text)
}

/// The drawing at the head of the unit has its parts, and no others.
#[test]
fn the_drawing_has_the_parts_of_the_unit() {
    for (node, features) in [(Wide4, NOTHING), (Quantised, NOTHING), (Wide4, CANDIDATES), (Wide8, EVERYTHING)] {
        let step = StepParameters { node, features, ..StepParameters::default() };
        let unit = UnitNetlist::new(Config::DEFAULT, UnitParameters { step, ..UnitParameters::default() });
        let top = unit.expect("a unit").top;
        let head = top.doc().join("\n");
        let drawn: BTreeSet<&str> = head.split_whitespace().filter(|word| word.starts_with("u_")).collect();
        assert_eq!(drawn, top.instances().iter().map(|instance| instance.name.as_str()).collect(), "{head}");
    }
}
