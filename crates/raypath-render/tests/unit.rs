//! The functional model of the traversal unit, compared with the tracer, whose hits `hits.rs` compares with exact
//! geometry, with exact geometry itself, and with the jobs of all triangles.

use crate::common::meshes::{self, Named};
use crate::common::oracle::Oracle;
use crate::common::rays::{Kind, rays};
use rayon::prelude::*;
use raypath_model::Shape;
use raypath_ops::{Binary32, Culling, Operation, Ray, RayTriangleExtended, RayTriangleExtendedInput, Rules, Triangle};
use raypath_render::{
    Camera, Goal, Mesh, PictureSpec, RayBatch, Scene, Shading, Tracer, Tracing, UnitErrors, UnitSystem,
    parse_instances, render, time_picture_through_unit, time_rays_through_unit, trace_any, trace_closest,
};
use raypath_timing::Sample;
use raypath_traversal::blocks::NodeKind;
use raypath_traversal::system::{CacheParameters, SystemParameters};
use raypath_traversal::{RayRequest, StepParameters, Unit, UnitParameters, ray_flags};
use std::path::Path;

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

/// Triangles in one place, between others or alone: the tree stays within the levels that the unit reads.
#[test]
fn coincident_triangles_are_hit() {
    let tracing = Tracing { two_sided: true, ..Tracing::default() };
    let [front, behind] = [5.0, -5.0].map(|z: f32| Ray::new([0.25, 0.25, z], [0.0, 0.0, -z.signum()], f32::INFINITY));
    let rays = [front.unwrap(), behind.unwrap()];
    for (copies, others) in [(190, 0), (200, 0), (100_000, 0), (3_000, 300)] {
        let mut positions = vec![[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
        let mut triangles = vec![[0, 1, 2]; copies];
        for number in 0..others {
            let first = positions.len() as u32;
            positions.extend([0.0, 1.0, 2.0].map(|x| [3.0 + x * number as f32, 1.3_f32.powi(number % 90), x]));
            triangles.push([first, first + 1, first + 2]);
        }
        let scene = Scene::new(Mesh::new(positions, triangles).unwrap()).unwrap();
        for nodes in NodeKind::ALL {
            let scene = scene.clone().through_unit_of(nodes).unwrap();
            let (hits, _) = trace_closest(&scene, &rays, tracing, &|_| true).unwrap();
            let hits: Vec<_> = hits.iter().flatten().map(|hit| (hit.triangle, hit.t, hit.from_behind)).collect();
            assert_eq!(hits, [(0, 4.0, false), (0, 6.0, true)], "{copies} copies, {others} others, {nodes} nodes");
        }
    }
}

/// In the space of an instance that is 2³⁰ times as large as its mesh, the first ray is too short to invert: the unit
/// ends it with an error. Nothing shows that as a miss.
#[test]
fn rays_that_the_unit_ends_with_an_error_are_errors() {
    let small = 2.0_f32.powi(-30);
    let corners = vec![[0.0, 0.0, small], [small, 0.0, small], [0.0, small, small]];
    let place = parse_instances("1073741824 0 0 0 0 1073741824 0 0 0 0 1073741824 0", Path::new("places")).unwrap();
    let scene = Scene::of_instances(Mesh::new(corners, vec![[0, 1, 2]]).unwrap(), &place, []).unwrap();
    let ray = |dz| Ray::new([0.25, 0.25, 5.0], [0.0, 0.0, dz], f32::INFINITY).unwrap();
    let rays = [ray(-(2.0_f32.powi(-100))), ray(-1.0)];
    let (errors, tracing) = (UnitErrors { refused: 0, failed: 1 }, Tracing::default());
    assert_eq!(trace_closest(&scene, &rays, tracing, &|_| true), Err(errors.into()));
    assert_eq!(trace_any(&scene, &rays, tracing, &|_| true), Err(errors.into()));
    let (hits, _) = trace_closest(&scene, &rays[1..], tracing, &|_| true).unwrap();
    assert_eq!(hits[0].map(|hit| (hit.triangle, hit.t, hit.instance)), Some((0, 4.0, Some(0))));
    let unit = UnitParameters::default();
    let around = SystemParameters::of_latency(1);
    let system = UnitSystem { shape: Shape::default(), unit, around, in_flight: 2 };
    let batch = RayBatch { scene: &scene, rays: &rays, tracing };
    assert_eq!(time_rays_through_unit(&batch, Sample::ALL, &system, &|_| true).err(), Some(errors.into()));
    // A camera whose rays are as short.
    let camera = Camera::framing_instances(scene.mesh(), &place, 1.0);
    let picture = render(&scene, &camera, (4, 4), &Shading::default(), &|_| true);
    assert!(picture.is_ok(), "rays of a camera are long enough");
    assert!(errors.to_string().starts_with("what 1 rays hit is not known: the traversal unit ended 1 with an error"));
}

/// The closest triangle, and its distance, among the jobs of all triangles.
fn of_all(mesh: &Mesh, ray: &Ray<Binary32>) -> Option<(u32, f32)> {
    let hits = (0..mesh.triangles().len() as u32).filter_map(|index| Some((index, of_one(mesh, ray, index)?)));
    hits.min_by(|(_, a), (_, b)| a.total_cmp(b))
}

/// The distance of a triangle, front or back.
pub fn of_one(mesh: &Mesh, ray: &Ray<Binary32>, index: u32) -> Option<f32> {
    let both_faces = RayTriangleExtended { culling: Culling::None, facing: true, ..RayTriangleExtended::PLAIN };
    let [a, b, c] = mesh.corners(index);
    let input = RayTriangleExtendedInput { ray: *ray, triangle: Triangle::new(a, b, c), t_min: 0.0.into() };
    let (outcome, ()) = both_faces.run(Binary32, input, ());
    let t = f32::from(outcome.t_num) / f32::from(outcome.t_denom);
    (bool::from(outcome.triangle_hit) && t <= f32::from(ray.extent)).then_some(t)
}

/// The simulated unit draws the picture of the functional model and does its work, whatever the memory.
#[test]
fn a_picture_through_the_simulated_unit() {
    let cache = CacheParameters { sets: 16, ways: 2, line: 128, misses: 8 };
    let systems = [
        SystemParameters::of_latency(1),
        SystemParameters { bandwidth: Some(16), ..SystemParameters::of_latency(300) },
        SystemParameters { units: 3, cache: Some(cache), shared: None, latency: 90, bandwidth: Some(64) },
    ];
    let shading = Shading { shadows: true, ambient_occlusion: 2, ..Shading::default() };
    for Named { name, mesh } in [meshes::real("suzanne"), meshes::real("truck")] {
        let camera = Camera::framing(&mesh, 1.5);
        let scene = Scene::new(mesh).unwrap().through_unit().unwrap();
        let (spec, size) = (PictureSpec { scene: &scene, camera, size: (48, 32), shading }, (48, 32));
        let expected = render(&scene, &camera, size, &shading, &|_| true).unwrap();
        let costs = [expected.primary, expected.shadow, expected.occlusion];
        let [rays, boxes, triangles] = [
            costs.iter().map(|costs| costs.rays).sum(),
            costs.iter().map(|costs| costs.counts.quadbox).sum(),
            costs.iter().map(|costs| costs.counts.triangle).sum::<u64>(),
        ];
        for (around, contexts) in systems.into_iter().zip([8, 64, 20]) {
            let unit = UnitParameters { contexts, ..UnitParameters::default() };
            let system = UnitSystem { shape: Shape::default(), unit, around, in_flight: 2 * contexts as usize };
            let (timing, picture) = time_picture_through_unit(&spec, Sample::ALL, &system, &|_| true).unwrap();
            assert!(picture == expected.picture, "{name}, {around:?}: another picture");
            let found = timing.unit;
            assert_eq!((found.rays, found.boxes, found.triangles), (rays, boxes, triangles), "{name}, {around:?}");
            let fetched = if around.cache.is_some() { timing.cache.misses } else { found.fetches };
            assert_eq!(timing.beats, 2 * fetched, "beats of 512 bits");
            let bytes = 128 * fetched;
            let least = around.bandwidth.map_or(0, |bandwidth| bytes / u64::from(bandwidth));
            assert!(found.cycles > least.max(timing.beats), "{name}, {around:?}: {timing:?}");
            assert_eq!(timing.cache.hits > 0, around.cache.is_some(), "{name}, {around:?}");
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
        let around = SystemParameters::of_latency(latency);
        let unit = UnitParameters { contexts: 8, ..UnitParameters::default() };
        let system = UnitSystem { shape: Shape::default(), unit, around, in_flight: 1 };
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
                    flags: ray_flags::CULL_BACK_FACING_TRIANGLES,
                    root: blocks.root(),
                    ..RayRequest::NONE
                };
                let reply = unit.trace(blocks.bytes(), &request);
                let (hit, best) =
                    (reply.hit.map(|hit| (hit.primitive, hit.t)), expected.map(|hit| (hit.triangle, hit.t)));
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
