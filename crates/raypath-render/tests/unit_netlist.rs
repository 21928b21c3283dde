//! The traversal unit on real meshes and degenerate scenes: its cycle-exact model, its simulated netlist and its text
//! in Verilator are equal at every port in every cycle, and every reply is that of the functional model.

use crate::common::meshes::{self, Named};
use crate::common::rays::{Kind, rays};
use raypath_render::{Mesh, Scene};
use raypath_rtl::Config;
use raypath_tools::{Options, Sources, ToolError, Verilated};
use raypath_traversal::traffic::{Behaviour, Environment, RecordedEngine};
use raypath_traversal::{
    NetlistEngine, RayRequest, Unit, UnitModel, UnitNetlist, UnitOutputs, UnitParameters, UnitPorts, ray_flags,
};
use std::sync::mpsc;

#[test]
fn netlist_and_models_agree_on_meshes_and_degenerate_scenes() {
    let unit = unit();
    let mut netlist = NetlistEngine::new(&unit).expect("a simulation");
    for Named { name, mesh } in meshes::all().into_iter().chain(degenerate()) {
        let subject = Subject::new(name, &mesh, 80);
        let (mut model, mut environment) = (UnitModel::of(&unit), subject.environment(unit.parameters));
        netlist.restart_randomly(1);
        while !environment.is_done() {
            environment.cycle(&mut [&mut model, &mut netlist]).unwrap_or_else(|problem| panic!("{name}: {problem}"));
        }
        subject.check(&environment, unit.parameters);
    }
}

/// A million rays on each of the four meshes, and 40,000 on each degenerate scene.
#[test]
#[ignore = "long: an hour"]
fn verilator_netlist_and_models_agree_on_a_million_rays() {
    let unit = unit();
    let folder = tempfile::tempdir().expect("a folder");
    let mut sources = Sources::write(&unit.top, folder.path()).expect("sources");
    sources.add(folder.path().join("raypath_properties.sv"), &unit.properties()).expect("the assertions");
    let options = Options::default();
    let verilated = Verilated::build_sources(&sources.files, &unit.top, folder.path(), &options).expect("a build");
    let meshes = meshes::all().into_iter().map(|mesh| (mesh, 1_000_000));
    for (Named { name, mesh }, count) in meshes.chain(degenerate().into_iter().map(|mesh| (mesh, 40_000))) {
        let subject = Subject::new(name, &mesh, count / Kind::ALL.len());
        let mut environment = subject.environment(unit.parameters);
        let cycles =
            in_verilator(&unit, &verilated, &mut environment).unwrap_or_else(|error| panic!("{name}: {error}"));
        subject.check(&environment, unit.parameters);
        println!("{name}: {} rays, {cycles} cycles", subject.rays.len());
    }
}

fn unit() -> UnitNetlist {
    let parameters = UnitParameters { contexts: 32, memory_width: 1024, id_width: 20, ..UnitParameters::default() };
    UnitNetlist::new(Config::DEFAULT, parameters).expect("a unit")
}

/// Rays on a scene in memory.
struct Subject {
    name: &'static str,
    scene: Vec<u8>,
    rays: Vec<RayRequest>,
}

/// The faces that are not hit.
const CULLS: [u32; 4] = [
    0,
    ray_flags::CULL_BACK_FACING_TRIANGLES,
    ray_flags::CULL_FRONT_FACING_TRIANGLES,
    ray_flags::SKIP_CLOSEST_HIT_SHADER,
];

impl Subject {
    /// So many rays of each kind. Every third ray wants any hit, and each culls other faces.
    fn new(name: &'static str, mesh: &Mesh, count: usize) -> Self {
        let scene = Scene::new(mesh.clone()).expect("a scene").through_unit().expect("a scene in memory");
        let blocks = scene.blocks().expect("a scene in memory");
        let all = Kind::ALL.into_iter().flat_map(|kind| rays(mesh, kind, count, 7));
        let request = |(number, ray): (usize, raypath_ops::Ray<raypath_ops::Binary32>)| RayRequest {
            origin: ray.origin.into(),
            direction: ray.dir.into(),
            t_min: if number % 5 == 4 { f32::from(ray.extent).min(1.0) / 2.0 } else { 0.0 },
            t_max: ray.extent.into(),
            flags: [0, 0, ray_flags::TERMINATE_ON_FIRST_HIT][number % 3] | CULLS[number % 4],
            root: blocks.root(),
            ..RayRequest::NONE
        };
        let rays = all.enumerate().map(request).collect();
        Self { name, scene: blocks.bytes().to_vec(), rays }
    }

    fn environment(&self, parameters: UnitParameters) -> Environment<'_> {
        let behaviour = Behaviour { latency: (1, 40), stalls: [0, 20, 20, 20], errors: 0 };
        Environment::new(&self.scene, parameters, self.rays.clone(), behaviour, 3)
    }

    /// Compares all replies with those of the functional model.
    fn check(&self, environment: &Environment<'_>, parameters: UnitParameters) {
        let mut functional = Unit::new(raypath_ops::Rules::Paper, parameters.step);
        assert_eq!(environment.replies.len(), self.rays.len(), "{}", self.name);
        for (&id, reply) in &environment.replies {
            let ray = &self.rays[id as usize];
            assert_eq!(*reply, functional.trace(&self.scene[..], ray), "{}: {ray:?}", self.name);
        }
    }
}

/// Runs Verilator, the netlist and the cycle-exact model through an environment. Returns the number of cycles.
fn in_verilator(
    unit: &UnitNetlist,
    verilated: &Verilated,
    environment: &mut Environment<'_>,
) -> Result<usize, ToolError> {
    let model = RecordedEngine::new(UnitModel::of(unit), &unit.top);
    let netlist = NetlistEngine::new(unit).expect("a simulation");
    let ports = UnitPorts::of(&unit.top);
    let (sender, outputs) = mpsc::channel();
    let mut cycles = 0;
    verilated.run_randomly(1, Frames { environment, model, netlist, sender }, |cycle, found| {
        let expected = outputs.recv().expect("the outputs of the model");
        assert_eq!(Some(ports.outputs(found)), expected, "cycle {cycle}");
        cycles = cycle + 1;
    })?;
    Ok(cycles)
}

/// The inputs of each cycle, until all rays have ended.
struct Frames<'e, 's> {
    environment: &'e mut Environment<'s>,
    model: RecordedEngine<UnitModel>,
    netlist: NetlistEngine,
    sender: mpsc::Sender<Option<UnitOutputs>>,
}

impl Iterator for Frames<'_, '_> {
    type Item = Vec<u64>;

    fn next(&mut self) -> Option<Vec<u64>> {
        if self.environment.is_done() {
            return None;
        }
        self.environment.cycle(&mut [&mut self.model, &mut self.netlist]).unwrap_or_else(|problem| panic!("{problem}"));
        let cycle = self.model.cycles.pop()?;
        // The receiver lives until the last frame has run.
        let _ = self.sender.send(cycle.outputs);
        Some(cycle.frame)
    }
}

/// Meshes of one triangle, of equal triangles, of slivers, of a leaf of eight, and of faces that occur twice.
fn degenerate() -> Vec<Named> {
    let triangle = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.25], [0.0, 1.0, 0.5]];
    let slivers = (0..60).flat_map(|k| {
        let x = k as f32 / 30.0 - 1.0;
        [[x, -1.0, 0.0], [x + 1e-5, 1.0, 0.0], [x, 1.0, 1e-6 * k as f32]]
    });
    let stairs = (0..8).flat_map(|k| triangle.map(|[x, y, z]| [x, y, z + k as f32 / 8.0]));
    let suzanne = meshes::real("suzanne").mesh;
    let doubled = (0..200).flat_map(|index| [suzanne.corners(index), suzanne.corners(index)]).flatten();
    let named = |name, positions: Vec<[f32; 3]>| {
        let triangles = (0..positions.len() as u32 / 3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        Named { name, mesh: Mesh::new(positions, triangles).expect("a mesh") }
    };
    vec![
        named("one triangle", triangle.to_vec()),
        named("equal triangles", std::iter::repeat_n(triangle, 100).flatten().collect()),
        named("slivers", slivers.collect()),
        named("a leaf of eight", stairs.collect()),
        named("doubled faces", doubled.collect()),
    ]
}
