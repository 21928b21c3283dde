//! The functional model of the traversal unit, compared with the tracer, whose hits `hits.rs` compares with exact
//! geometry, with exact geometry itself, and with the jobs of all triangles.

use crate::common::meshes::{self, Named};
use crate::common::oracle::Oracle;
use crate::common::rays::{Kind, rays};
use rayon::prelude::*;
use raypath_model::Shape;
use raypath_ops::{
    Binary32, Culling, Operation, Ray, RayTriangleExtended, RayTriangleExtendedInput, Rounding, Rules, Triangle,
};
use raypath_render::{
    Camera, Goal, Mesh, PictureSpec, RayBatch, Scene, Shading, Tracer, Tracing, UnitSystem, render,
    time_picture_through_unit, time_rays_through_unit, trace_any, trace_closest,
};
use raypath_timing::Sample;
use raypath_traversal::system::{CacheParameters, MemoryParameters};
use raypath_traversal::{RayRequest, StepParameters, Unit, UnitParameters};

/// Hits of front faces are the same in every bit.
#[test]
fn hits_through_the_unit_are_those_of_the_tracer() {
    for Named { name, mesh } in meshes::all() {
        let scene = Scene::new(mesh.clone()).unwrap();
        let in_memory = scene.clone().through_unit().unwrap();
        for rules in [Rules::Paper, Rules::Chisel] {
            let tracing = Tracing { two_sided: false, rules };
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

/// Hits of both faces. The unit tests a back face without exchanging its vertices, so its sums round differently from
/// those of the tracer: the references are exact geometry, and the same job for every triangle.
#[test]
fn hits_of_both_faces() {
    let mut behind = 0;
    for Named { name, mesh } in meshes::all() {
        let (oracle, tracing) = (Oracle::new(&mesh, true), Tracing { two_sided: true, rules: Rules::Paper });
        let scene = Scene::new(mesh.clone()).unwrap().through_unit().unwrap();
        for kind in Kind::ALL {
            let rays = rays(&mesh, kind, 500, 5);
            let (hits, _) = trace_closest(&scene, &rays, tracing, &|_| true).unwrap();
            rays.par_iter().zip(&hits).enumerate().for_each(|(index, (ray, &hit))| {
                oracle.check(ray, hit).unwrap_or_else(|error| panic!("{name}, {kind:?}, {ray:?}: {error}"));
                if index < 100 {
                    assert_eq!(hit.map(|hit| (hit.triangle, hit.t)), of_all(&mesh, ray), "{name}, {kind:?}, {ray:?}");
                }
            });
            behind += hits.iter().flatten().filter(|hit| hit.from_behind).count();
        }
    }
    assert!(behind > 100, "back faces are hit: {behind} times");
}

/// The closest triangle, and its distance, among the jobs of all triangles.
fn of_all(mesh: &Mesh, ray: &Ray<Binary32>) -> Option<(u32, f32)> {
    let both_faces = RayTriangleExtended {
        rules: Rules::Paper,
        rounding: Rounding::Unit,
        culling: Culling::None,
        facing: true,
        barycentrics: false,
        range: false,
    };
    let hits = (0..mesh.triangles().len() as u32).filter_map(|index| {
        let [a, b, c] = mesh.corners(index);
        let input = RayTriangleExtendedInput { ray: *ray, triangle: Triangle::new(a, b, c), t_min: 0.0.into() };
        let (outcome, ()) = both_faces.run(Binary32, input, ());
        let t = f32::from(outcome.t_num) / f32::from(outcome.t_denom);
        (bool::from(outcome.triangle_hit) && t <= f32::from(ray.extent)).then_some((index, t))
    });
    hits.min_by(|(_, a), (_, b)| a.total_cmp(b))
}

/// The simulated unit draws the picture of the functional model and does its work, whatever the memory.
#[test]
fn a_picture_through_the_simulated_unit() {
    let cache = CacheParameters { bytes: 4096, ways: 2, line: 128, hit_latency: 3 };
    let memories = [
        MemoryParameters { latency: 1, bandwidth: None, cache: None },
        MemoryParameters { latency: 300, bandwidth: Some(16), cache: None },
        MemoryParameters { latency: 90, bandwidth: Some(64), cache: Some(cache) },
    ];
    let shading = Shading { shadows: true, ambient_occlusion: 2, ..Shading::default() };
    for Named { name, mesh } in [meshes::real("suzanne"), meshes::real("truck")] {
        let camera = Camera::framing(&mesh, 1.5);
        let scene = Scene::for_origins(mesh, [camera.eye()]).unwrap().through_unit().unwrap();
        let (spec, size) = (PictureSpec { scene: &scene, camera, size: (48, 32), shading }, (48, 32));
        let expected = render(&scene, &camera, size, &shading, &|_| true).unwrap();
        let costs = [expected.primary, expected.shadow, expected.occlusion];
        let [rays, boxes, triangles] = [
            costs.iter().map(|costs| costs.rays).sum(),
            costs.iter().map(|costs| costs.counts.quadbox).sum(),
            costs.iter().map(|costs| costs.counts.triangle).sum::<u64>(),
        ];
        for (memory, contexts) in memories.into_iter().zip([8, 64, 20]) {
            let unit = UnitParameters { contexts, ..UnitParameters::default() };
            let system = UnitSystem { shape: Shape::default(), unit, memory, in_flight: 2 * contexts as usize };
            let (timing, picture) = time_picture_through_unit(&spec, Sample::ALL, &system, &|_| true).unwrap();
            assert!(picture == expected.picture, "{name}, {memory:?}: another picture");
            let found = timing.unit;
            assert_eq!((found.rays, found.boxes, found.triangles), (rays, boxes, triangles), "{name}, {memory:?}");
            assert_eq!(timing.beats, 2 * found.fetches, "beats of 512 bits");
            let bytes = 128 * if memory.cache.is_some() { timing.cache_misses } else { found.fetches };
            let least = memory.bandwidth.map_or(0, |bandwidth| bytes / u64::from(bandwidth));
            assert!(found.cycles > least.max(timing.beats), "{name}, {memory:?}: {timing:?}");
            assert_eq!(timing.cache_hits > 0, memory.cache.is_some(), "{name}, {memory:?}");
        }
    }
}

/// One ray at a time: each of its fetches takes the latency of the memory, the datapath and the steps.
#[test]
fn the_time_of_a_ray_alone_follows_from_its_fetches() {
    let Named { mesh, .. } = meshes::real("suzanne");
    let rays = rays(&mesh, Kind::Primary, 200, 1);
    let scene = Scene::new(mesh).unwrap().through_unit().unwrap();
    let batch = RayBatch { scene: &scene, rays: &rays, tracing: Tracing::default() };
    let cycles = |latency: u64| {
        let memory = MemoryParameters { latency, bandwidth: None, cache: None };
        let unit = UnitParameters { contexts: 8, ..UnitParameters::default() };
        let system = UnitSystem { shape: Shape::default(), unit, memory, in_flight: 1 };
        let (timing, hits) = time_rays_through_unit(&batch, Sample::ALL, &system, &|_| true).unwrap();
        assert_eq!(hits, trace_closest(&scene, &rays, Tracing::default(), &|_| true).unwrap().0);
        (timing.unit.cycles, timing.unit.fetches)
    };
    let ((fast, fetches), (slow, as_many)) = (cycles(10), cycles(510));
    assert_eq!(fetches, as_many);
    assert_eq!(slow - fast, 500 * fetches, "each fetch takes as much longer as the memory does");
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
        let mut tracer = Tracer::new(&scene, Tracing::default());
        for ray in rays(&mesh, Kind::Random, 2_000, 4) {
            let expected = tracer.trace(&ray, Goal::Closest);
            for stack in [2, 4, 8, 16, 32] {
                let mut unit = Unit::new(Rules::Paper, StepParameters { stack, ..StepParameters::default() });
                let request = RayRequest {
                    origin: ray.origin.into(),
                    direction: ray.dir.into(),
                    t_min: 0.0,
                    t_max: ray.extent.into(),
                    any_hit: false,
                    cull_back: true,
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
