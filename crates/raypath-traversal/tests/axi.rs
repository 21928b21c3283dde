//! The wrapper with an AXI4 read master has the unit's behaviour, and the linters have nothing to say about it.

use rand::rngs::ChaCha8Rng;
use rand::{Rng, SeedableRng};
use raypath_hdl::{Driver, Module, SignalId};
use raypath_ops::Rules;
use raypath_rtl::Config;
use raypath_tools::{Options, Sources, Verilated, lint_verilator};
use raypath_traversal::system::{Cache, CacheBeat, CacheEdge, CacheParameters, Stored};
use raypath_traversal::traffic::{Behaviour, BlockScene, Environment, random_ray};
use raypath_traversal::{
    BlockRequest, RayRequest, Reply, Response, Unit, UnitEngine, UnitInputs, UnitModel, UnitNetlist, UnitOutputs,
    UnitParameters, UnitPorts,
};
use std::collections::BTreeMap;

/// The port of the wrapper for one of the unit.
fn of_wrapper(port: &str) -> String {
    let Some(memory) = port.strip_prefix("mem_") else { return port.to_string() };
    let axi = match memory {
        "req_valid_o" => "arvalid",
        "req_ready_i" => "arready",
        "req_addr_o" => "araddr",
        "req_tag_o" => "arid",
        "rsp_valid_i" => "rvalid",
        "rsp_ready_o" => "rready",
        "rsp_tag_i" => "rid",
        "rsp_error_i" => "rresp",
        data => return format!("m_axi_r{}", data.trim_start_matches("rsp_").trim_end_matches("_i")),
    };
    format!("m_axi_{axi}")
}

fn netlists(contexts: u32, memory_width: u32, address_width: u32) -> (UnitNetlist, std::sync::Arc<Module>) {
    let parameters = UnitParameters { contexts, memory_width, id_width: 9, address_width, ..UnitParameters::default() };
    let unit = UnitNetlist::new(Config::DEFAULT, parameters).expect("a unit");
    let axi = unit.axi().expect("a wrapper");
    (unit, axi)
}

/// With addresses of so many bits that a ray brings some of them.
#[test]
fn the_linters_are_silent() {
    let (unit, axi) = netlists(65, 128, 40);
    assert_eq!(axi.port_width("m_axi_araddr"), Some(40));
    let folder = tempfile::tempdir().expect("a folder");
    let mut sources = Sources::write(&axi, folder.path()).expect("sources");
    sources.lint().expect("no report of the linters");
    sources.add(folder.path().join("raypath_properties.sv"), &unit.properties()).expect("the assertions");
    let arguments = ["--assert", "-Wno-DECLFILENAME"];
    lint_verilator(&sources.files, axi.name(), &arguments).expect("nor of Verilator with the assertions");
}

/// A unit with a cache in a wrapper, as the models have both.
struct Cached {
    unit: UnitModel,
    cache: Cache,
    /// The beats in the store, and that which leaves the cache.
    store: BTreeMap<Stored, Vec<u8>>,
    read: Vec<u8>,
    ports: UnitPorts,
    random: ChaCha8Rng,
    frames: Vec<Vec<u64>>,
    outputs: Vec<UnitOutputs>,
}

impl UnitEngine for Cached {
    fn outputs(&mut self) -> UnitOutputs {
        let request = self.cache.request().map(|(address, tag)| BlockRequest { address, tag });
        UnitOutputs { request, ..self.unit.outputs() }
    }

    fn cycle(&mut self, inputs: &UnitInputs<'_>) {
        let outputs = self.outputs();
        self.outputs.push(outputs);
        let random = &mut self.random;
        let words = self.ports.words(inputs, || random.next_u64());
        // The wrapper has the memory's channels last, in another order.
        let (of_users, of_memory) = words.split_at(words.len() - 4 - DATA_WORDS);
        let [ready, valid, tag, error, ref data @ ..] = of_memory[..] else { panic!("the memory's ports") };
        let invalidates = 0;
        self.frames.push([&[1], of_users, &[invalidates, ready, tag], data, &[2 * error, tag & 1, valid]].concat());

        let request = self.unit.outputs().request;
        let response = self.cache.response().map(|CacheBeat { tag, is_error, .. }| (tag, is_error));
        let request_ready = self.cache.ready();
        let filled = inputs.response.map(|beat| self.cache.place_of(beat.tag));
        self.cache.cycle(&CacheEdge {
            invalidates: false,
            request: request.map(|request| (request.address, request.tag)),
            memory_ready: inputs.request_ready,
            beat: inputs.response.map(|beat| (beat.tag, beat.is_error)),
        });
        let beat = self.read.clone();
        let response = response.map(|(tag, is_error)| Response { tag, is_error, beat: &beat });
        self.unit.cycle(&UnitInputs { request_ready, response, ..*inputs });
        // What leaves in the next cycle was read before the beat of this one is written.
        let next = self.cache.response().and_then(|beat| self.store.get(&beat.stored));
        self.read = next.cloned().unwrap_or_else(|| vec![0; 4 * DATA_WORDS]);
        self.store.extend(filled.zip(inputs.response.map(|beat| beat.beat.to_vec())));
    }

    fn reset(&mut self) {
        panic!("the cache has no reset");
    }
}

const MEMORY_WIDTH: u32 = 256;
const DATA_WORDS: usize = MEMORY_WIDTH as usize / 32;

/// The wrapper's text with a cache does in each cycle what the models of unit and cache do, and rays have the hits of the
/// functional model.
#[test]
fn a_unit_with_a_cache_is_that_of_the_models() {
    let (unit, axi) = netlists(16, MEMORY_WIDTH, 32);
    let cache = CacheParameters { sets: 8, ways: 2, line: 128, misses: 4 };
    let folder = tempfile::tempdir().expect("a folder");
    let sources = Sources::write(&axi, folder.path()).expect("sources");
    let wrapper = sources.files.last().expect("the wrapper");
    let text = std::fs::read_to_string(wrapper).expect("a text");
    let defaults = ["CacheSets      = 0", "CacheWays      = 4", "CacheMisses    = 8"];
    let values = ["CacheSets      = 8", "CacheWays      = 2", "CacheMisses    = 4"];
    let cached = defaults.iter().zip(values).fold(text.clone(), |text, (from, to)| text.replace(from, to));
    assert_eq!(text.len(), cached.len());
    std::fs::write(wrapper, cached).expect("a text");
    lint_verilator(&sources.files, axi.name(), &[]).expect("no report of Verilator");
    let verilated =
        Verilated::build_sources(&sources.files, &axi, folder.path(), &Options::default()).expect("a build");

    let mut random = ChaCha8Rng::seed_from_u64(3);
    let (scene, root) = BlockScene::random(150, &mut random);
    let rays: Vec<RayRequest> = (0..150).map(|_| random_ray(root, &mut random)).collect();
    let ports = UnitPorts::of(&unit.top);
    let mut engine = Cached {
        unit: UnitModel::of(&unit),
        cache: Cache::new(cache, 128, MEMORY_WIDTH, 16),
        store: BTreeMap::new(),
        read: vec![0; 4 * DATA_WORDS],
        ports: ports.clone(),
        random,
        frames: Vec::new(),
        outputs: Vec::new(),
    };
    let behaviour = Behaviour { latency: (1, 60), stalls: [10, 40, 60, 60], errors: 0 };
    let mut environment = Environment::new(&scene.0, unit.parameters, rays.clone(), behaviour, 7);
    while !environment.is_done() {
        environment.cycle(&mut [&mut engine]).expect("the protocol");
    }
    let mut functional = Unit::new(Rules::Paper, unit.parameters.step);
    let expected: Vec<Reply> = rays.iter().map(|ray| functional.trace(&scene.0[..], ray)).collect();
    assert!(environment.replies.values().eq(&expected));
    let counts = engine.cache.counts();
    assert!(counts.hits > 200 && counts.merges > 20 && counts.misses > 200, "{counts:?}");
    let Cached { frames, outputs, .. } = engine;
    let of_memory = ["m_axi_arvalid", "m_axi_araddr", "m_axi_arid", "m_axi_rready"]
        .map(|name| axi.outputs().iter().position(|port| port.name == name).expect("an output"));
    let of_users = axi.outputs().iter().take_while(|port| !port.name.starts_with("m_axi")).count();
    verilated
        .run_randomly(1, frames, |cycle, found| {
            let words: Vec<u64> = found[..of_users].iter().copied().chain(of_memory.map(|port| found[port])).collect();
            assert_eq!(ports.outputs(&words), outputs[cycle], "cycle {cycle}");
        })
        .expect("a run");
}

/// The wrapper is wires alone, so that it does what the unit does with any inputs: each of its ports is that of the unit,
/// but for the error of a response, which is any response that is not OKAY, and for signals that are constant.
#[test]
fn the_wrapper_connects_the_ports_of_the_unit_and_nothing_else() {
    for (memory_width, length, size) in [(128, 7, 4), (256, 3, 5), (512, 1, 6), (1024, 0, 7)] {
        let (unit, axi) = netlists(8, memory_width, 64);
        let [instance] = axi.instances() else { panic!("one instance") };
        assert_eq!((axi.registers().len(), axi.memories().len(), instance.module.name()), (0, 0, unit.top.name()));
        let input = |signal: SignalId| axi.inputs().iter().find(|port| port.signal == signal).map(|port| &port.name);
        for (port, &signal) in unit.top.inputs().iter().zip(&instance.inputs) {
            let wire = match axi.signal(signal).driver {
                Driver::Any(response) if port.name == "mem_rsp_error_i" => response,
                _ => signal,
            };
            assert_eq!(input(wire), Some(&of_wrapper(&port.name)), "{}", port.name);
        }
        let mut connected = 0;
        for port in axi.outputs() {
            let signal = axi.signal(port.signal);
            let constants =
                [("len", length), ("size", size), ("burst", 1), ("lock", 0), ("cache", 3), ("prot", 2), ("qos", 0)];
            match constants.into_iter().find(|(name, _)| port.name == format!("m_axi_ar{name}")) {
                Some((_, value)) => assert_eq!(signal.driver, Driver::Constant(value), "{}", port.name),
                None => {
                    let Driver::Instance { output, .. } = signal.driver else { panic!("{}", port.name) };
                    assert_eq!(of_wrapper(&unit.top.outputs()[output].name), port.name);
                    connected += 1;
                }
            }
        }
        assert_eq!(connected, unit.top.outputs().len());
    }
}
