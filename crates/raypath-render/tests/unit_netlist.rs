//! The traversal unit on real meshes and degenerate scenes: its cycle-exact model and its simulated netlist are equal at
//! every port in every cycle, and every reply is that of the functional model.

use crate::common::meshes::{self, Named};
use crate::common::rays::{Kind, rays};
use raypath_render::{Mesh, Scene};
use raypath_rtl::Config;
use raypath_traversal::traffic::{Behaviour, Environment};
use raypath_traversal::{NetlistEngine, RayRequest, Unit, UnitModel, UnitNetlist, UnitParameters, ray_flags};

#[test]
fn netlist_and_models_agree_on_meshes_and_degenerate_scenes() {
    let unit = unit();
    let mut netlist = NetlistEngine::new(&unit).expect("a simulation");
    for Named { name, mesh } in meshes::all().into_iter().chain(degenerate()) {
        let subject = Subject::new(name, &mesh);
        let (mut model, mut environment) = (UnitModel::of(&unit), subject.environment(unit.parameters));
        netlist.restart_randomly(1);
        while !environment.is_done() {
            environment.cycle(&mut [&mut model, &mut netlist]).unwrap_or_else(|problem| panic!("{name}: {problem}"));
        }
        subject.check(&environment, unit.parameters);
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
    /// 80 rays of each kind. Every third ray wants any hit, and each culls other faces.
    fn new(name: &'static str, mesh: &Mesh) -> Self {
        let scene = Scene::new(mesh.clone()).expect("a scene").through_unit().expect("a scene in memory");
        let blocks = scene.blocks().expect("a scene in memory");
        let all = Kind::ALL.into_iter().flat_map(|kind| rays(mesh, kind, 80, 7));
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

/// Meshes of one triangle, of equal triangles, of slivers, of stairs, and of faces that occur twice.
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
        named("stairs", stairs.collect()),
        named("doubled faces", doubled.collect()),
    ]
}
