//! The functional model of the traversal unit, compared with the tracer, whose hits `hits.rs` compares with exact
//! geometry, and with brute force.

mod common;

use common::meshes::{self, Named};
use common::rays::{Kind, rays};
use raypath_ops::Rules;
use raypath_render::{Goal, Scene, Tracer, Tracing, trace_any, trace_closest};
use raypath_unit::{RayRequest, StepParameters, Unit};

/// All hits are the same in every bit.
#[test]
fn hits_through_the_unit_are_those_of_the_tracer() {
    for Named { name, mesh } in meshes::all() {
        let scene = Scene::new(mesh.clone()).unwrap();
        let in_memory = scene.clone().through_unit().unwrap();
        for (two_sided, rules) in [(false, Rules::Paper), (true, Rules::Paper), (true, Rules::Chisel)] {
            let tracing = Tracing { two_sided, rules };
            for kind in Kind::ALL {
                let rays = rays(&mesh, kind, 3_000, 3);
                let (expected, _) = trace_closest(&scene, &rays, tracing, &|_| true).unwrap();
                let (found, _) = trace_closest(&in_memory, &rays, tracing, &|_| true).unwrap();
                let different = expected.iter().zip(&found).filter(|(expected, found)| expected != found).count();
                assert_eq!(different, 0, "{name}, {kind:?}, {tracing:?}");
                assert!(found.iter().any(Option::is_some), "{name}, {kind:?}: no hits");
                let (expected, _) = trace_any(&scene, &rays, tracing, &|_| true).unwrap();
                let (found, _) = trace_any(&in_memory, &rays, tracing, &|_| true).unwrap();
                assert_eq!(expected, found, "{name}, {kind:?}, {tracing:?}: any hit");
            }
        }
    }
}

/// A short stack changes the work of a ray, not its hit. The longest does not overflow, and then the work is that of
/// the tracer.
#[test]
fn every_stack_gives_the_same_hits() {
    let mut repeated = 0;
    for Named { name, mesh } in meshes::all() {
        let scene = Scene::new(mesh.clone()).unwrap();
        let in_memory = scene.clone().through_unit().unwrap();
        let blocks = in_memory.blocks().unwrap();
        let mut tracer = Tracer::new(&scene, Tracing { two_sided: true, rules: Rules::Paper });
        for ray in rays(&mesh, Kind::Random, 2_000, 4) {
            let expected = tracer.trace(&ray, Goal::Closest);
            for stack in [2, 4, 8, 16, 32] {
                let mut unit = Unit::new(Rules::Paper, StepParameters { stack });
                let request = RayRequest {
                    origin: ray.origin.into(),
                    direction: ray.dir.into(),
                    t_min: 0.0,
                    t_max: ray.extent.into(),
                    any_hit: false,
                    cull_back: false,
                    cull_front: false,
                    root: blocks.root(),
                };
                let reply = unit.trace(blocks.bytes(), &request);
                let (hit, best) =
                    (reply.hit.map(|hit| (hit.triangle, hit.t)), expected.map(|hit| (hit.triangle, hit.t)));
                assert_eq!(hit, best, "{name}, stack of {stack}, {ray:?}");
                let more = u64::from(reply.nodes) - tracer.counts().nodes;
                repeated += more;
                if stack == 32 {
                    let triangles = tracer.counts().triangle;
                    assert_eq!((more, u64::from(reply.triangles)), (0, triangles), "{name}, {ray:?}");
                }
            }
        }
    }
    assert!(repeated > 1000, "short stacks overflow: {repeated} nodes were read again");
}
