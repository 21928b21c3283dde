//! Scenes of two levels: what a ray does in an instance, made by hand, and against every triangle in binary64.

use crate::common::{along_z, at, cross, dot, minus};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_model::Shape;
use raypath_ops::{Aabb, Binary32, Operation, Rules, Triangle};
use raypath_rtl::Config;
use raypath_traversal::blocks::{LeafTriangle, NodeKind};
use raypath_traversal::state::status;
use raypath_traversal::traffic::{BlockScene as Scene, TwoLevelScene, never, random_ray};
use raypath_traversal::{
    BlockRequest, INSTANCE_KIND, Instance, RayRequest, Reply, Response, Row, StepParameters, Transform, TransformInput,
    Unit, UnitEngine, UnitFeatures, UnitInputs, UnitModel, UnitNetlist, UnitParameters, ray_flags,
};

const STACKS: [u32; 5] = [2, 4, 8, 16, 32];
const BACK: u32 = ray_flags::CULL_BACK_FACING_TRIANGLES;
const FRONT: u32 = ray_flags::CULL_FRONT_FACING_TRIANGLES;
const INSTANCES: UnitFeatures = UnitFeatures { instances: true, ..UnitFeatures::OFF };
const IDENTITY: [[f32; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

fn trace(scene: &Scene, stack: u32, ray: &RayRequest) -> Reply {
    let Scene(bytes, node) = scene;
    let step = StepParameters { stack, node: *node, features: INSTANCES, ..StepParameters::default() };
    Unit::new(Rules::Paper, step).trace(&bytes[..], ray)
}

fn everywhere() -> Aabb<Binary32> {
    Aabb::new([-100.0; 3], [100.0; 3])
}

/// A node over these children, all of which every ray through the scene visits.
fn over<const N: usize>(scene: &mut Scene, of: [u32; N]) -> u32 {
    let (mut boxes, mut children) = ([never(); 4], [0; 4]);
    boxes[..N].fill(everywhere());
    children[..N].copy_from_slice(&of);
    scene.node(boxes, children)
}

/// The hit of a ray along z: instance, triangle, distance, back face.
fn found(scene: &Scene, root: u32) -> (Option<u32>, u32, f32, bool) {
    let replies = STACKS.map(|stack| trace(scene, stack, &along_z(root)).hit.expect("a hit"));
    let hits = replies.map(|hit| (hit.instance.map(|instance| instance.index), hit.primitive, hit.t, hit.back_face));
    assert!(hits.iter().all(|hit| *hit == hits[0]), "the stack changes the hit: {hits:?}");
    hits[0]
}

#[test]
fn a_hit_has_the_distance_and_the_face_of_the_object() {
    let mut scene = Scene::default();
    let object = scene.leaf(&[at(3.0, 7)]);
    let place = |scale: [f64; 3], z: f64| {
        let to_scene = [[scale[0], 0.0, 0.0, 0.0], [0.0, scale[1], 0.0, 0.0], [0.0, 0.0, scale[2], z]];
        Instance::placed(to_scene, object, 5).expect("an inverse")
    };
    for (instance, t, back_face) in [
        (place([1.0; 3], 0.0), 4.0, false),
        (place([2.0; 3], 1.0), 8.0, false),
        (place([0.5, 4.0, 0.25], -1.0), 0.75, false),
        // Faces are those of the object: a mirror changes the side from which the ray comes, or exchanges the vertices.
        (place([1.0, 1.0, -1.0], 8.0), 6.0, true),
        (place([-1.0, 1.0, 1.0], 0.0), 4.0, false),
    ] {
        let root = scene.instance(&instance);
        assert_eq!(found(&scene, root), (Some(5), 7, t, back_face), "{instance:?}");
        let root = over(&mut scene, [root]);
        assert_eq!(found(&scene, root), (Some(5), 7, t, back_face), "{instance:?} below a node");
    }
}

/// Of equal distances that in the lowest instance is reported, and what is in no instance last.
#[test]
fn ties_are_settled_by_instance_and_index() {
    for rotation in 0..4 {
        let mut scene = Scene::default();
        let object = scene.leaf(&[at(3.0, 4), at(3.0, 2), at(3.0, 3)]);
        let mut parts: [u32; 4] = std::array::from_fn(|place| {
            let index = (place as u32 + rotation) % 4;
            scene.instance(&Instance { root: object, index, ..Instance::default() })
        });
        parts[rotation as usize] = scene.leaf(&[at(3.0, 0)]);
        // The leaf is in the place of instance 0 or 2.
        let least = if rotation % 2 == 0 { 1 } else { 0 };
        let root = over(&mut scene, parts);
        assert_eq!(found(&scene, root), (Some(least), 2, 4.0, false), "rotation {rotation}");
        let root = over(&mut scene, [parts[rotation as usize]]);
        assert_eq!(found(&scene, root), (None, 0, 4.0, false));
    }
}

/// Boxes and triangles outside of an instance are tested with the ray outside, also after an instance.
#[test]
fn a_ray_leaves_an_instance() {
    let mut scene = Scene::default();
    // In the space of the object the ray runs along x, past every triangle.
    let aside = scene.leaf(&[at(3.0, 1)]);
    let missed = [[5.0, 5.0, 3.0], [6.0, 7.0, 3.0], [7.0, 5.0, 3.0]];
    let missed = scene.leaf(&[LeafTriangle { triangle: Triangle::new(missed[0], missed[1], missed[2]), index: 9 }]);
    let aside = over(&mut scene, [aside]);
    let to_object = [IDENTITY[2], IDENTITY[1], IDENTITY[0]];
    let instance = scene.instance(&Instance { to_object, root: aside, ..Instance::default() });
    let outside = scene.leaf(&[at(9.0, 2)]);
    let deep = over(&mut scene, [instance, outside]);
    for parts in [[instance, outside], [outside, instance], [instance, deep], [deep, instance]] {
        let root = over(&mut scene, parts);
        assert_eq!(found(&scene, root), (None, 2, 10.0, false));
    }
    // A short stack forgets levels outside while the ray is in the object: it begins again at the root, outside.
    let mut object = aside;
    for _ in 0..20 {
        object = over(&mut scene, [object, aside]);
    }
    let mut root = scene.instance(&Instance { to_object, root: object, ..Instance::default() });
    for _ in 0..20 {
        root = over(&mut scene, [root, missed]);
    }
    let root = over(&mut scene, [root, outside]);
    assert_eq!(found(&scene, root), (None, 2, 10.0, false));
}

#[test]
fn instances_that_no_ray_can_enter_end_it() {
    let error = |scene: &Scene, root: u32, features: UnitFeatures, expected: u32| {
        for stack in STACKS {
            let reply = Unit::new(Rules::Paper, StepParameters { stack, features, ..StepParameters::default() })
                .trace(&scene.0[..], &along_z(root));
            assert_eq!(reply.status, expected, "stack {stack}");
        }
    };
    let mut scene = Scene::default();
    let object = scene.leaf(&[at(3.0, 0)]);
    let fine = Instance { root: object, ..Instance::default() };
    let valid = scene.instance(&fine);
    assert_eq!(found(&scene, valid), (Some(0), 0, 4.0, false));
    error(&scene, valid, UnitFeatures::OFF, status::SCENE);
    // Nested, directly and below a node, in a unit that has no such instances; no valid kind; behind the end of the memory.
    let below = over(&mut scene, [valid]);
    for root in [valid, below, 31, 34] {
        let word = scene.instance(&Instance { root, ..fine });
        error(&scene, word, INSTANCES, status::SCENE);
    }
    let word = scene.instance(&Instance { root: 0x4000_0020, ..fine });
    error(&scene, word, INSTANCES, status::MEMORY);
    error(&scene, 0x4000_0000 | INSTANCE_KIND, INSTANCES, status::MEMORY);
    // Without a tree, an instance is not there, whatever its matrix.
    let word = scene.instance(&Instance { root: 0, to_object: [[0.0; 4]; 3], ..fine });
    error(&scene, word, INSTANCES, status::MISS);
    let root = over(&mut scene, [word, valid]);
    assert_eq!(found(&scene, root), (Some(0), 0, 4.0, false));
    // Directions and origins that are not finite, zero, or too short.
    let z = |number: f32, t: f32| [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, number, t]];
    for to_object in [z(0.0, 0.0), z(f32::NAN, 0.0), z(f32::INFINITY, 0.0), z(1e-40, 0.0), z(1.0, f32::NEG_INFINITY)] {
        let word = scene.instance(&Instance { to_object, ..fine });
        error(&scene, word, INSTANCES, status::SCENE);
    }
    // An instance is a level, of which there are 64.
    for (depth, is_valid) in [(63, true), (64, false)] {
        let mut root = valid;
        for _ in 0..depth {
            root = over(&mut scene, [root]);
        }
        if is_valid {
            assert_eq!(found(&scene, root), (Some(0), 0, 4.0, false))
        } else {
            error(&scene, root, INSTANCES, status::SCENE)
        }
    }
}

/// A world, groups and objects: a ray goes on in a group after an object of it, and leaves both. The hit is that of the
/// innermost instance, whatever the stack.
#[test]
fn instances_may_be_nested() {
    let mut scene = Scene::default();
    let moved = |z: f32| [IDENTITY[0], IDENTITY[1], [0.0, 0.0, 1.0, -z]];
    let aside = LeafTriangle { triangle: Triangle::new([5.0, 5.0, 3.0], [6.0, 7.0, 3.0], [7.0, 5.0, 3.0]), index: 9 };
    let (near, missed) = (scene.leaf(&[at(3.0, 1)]), scene.leaf(&[aside]));
    let instance = |scene: &mut Scene, root: u32, z: f32, index: u32| {
        scene.instance(&Instance { root, to_object: moved(z), index, ..Instance::default() })
    };
    // The nearest triangle is in the group itself, after an object that the ray passes.
    let passed = instance(&mut scene, missed, 0.0, 1);
    let far = instance(&mut scene, near, 50.0, 2);
    let group = over(&mut scene, [passed, far, near]);
    let first = instance(&mut scene, group, 10.0, 3);
    // A group with an object alone, moved twice.
    let object = instance(&mut scene, near, 2.0, 4);
    let second = instance(&mut scene, object, 4.0, 5);
    let loose = scene.leaf(&[at(40.0, 7)]);
    for (parts, expected) in [
        (vec![first], (Some(3), 1, 14.0)),
        (vec![first, second], (Some(4), 1, 10.0)),
        (vec![first, loose], (Some(3), 1, 14.0)),
        (vec![loose, first, second], (Some(4), 1, 10.0)),
    ] {
        let (mut boxes, mut children) = ([never(); 4], [0; 4]);
        boxes[..parts.len()].fill(everywhere());
        children[..parts.len()].copy_from_slice(&parts);
        let root = scene.node(boxes, children);
        for stack in STACKS {
            let features = UnitFeatures { nested: true, ..INSTANCES };
            let mut unit = Unit::new(Rules::Paper, StepParameters { stack, features, ..StepParameters::default() });
            let reply = unit.trace(&scene.0[..], &along_z(root));
            let hit = reply.hit.expect("a hit");
            assert_eq!((hit.instance.map(|instance| instance.index), hit.primitive, hit.t), expected, "stack {stack}");
        }
    }
}

/// A hit in binary64: distance, instance, triangle, and how far the ray is from the nearest edge, in weights.
#[derive(Debug, Clone, Copy)]
struct Exact {
    t: f64,
    instance: Option<u32>,
    triangle: u32,
    is_front: bool,
    margin: f64,
}

/// Where the ray meets the planes of all triangles, of faces that are not culled.
fn all_hits(scene: &TwoLevelScene, ray: &RayRequest) -> Vec<Exact> {
    let mut hits = Vec::new();
    let outside = (IDENTITY, None, &scene.outside);
    let inside = scene.instances.iter().map(|(instance, object)| (instance.to_object, Some(instance.index), object));
    for (to_object, instance, triangles) in [outside].into_iter().chain(inside) {
        let moved = |point: [f32; 3], by: f64| {
            to_object.map(|row| {
                let [x, y, z, t] = row.map(f64::from);
                x * f64::from(point[0]) + y * f64::from(point[1]) + z * f64::from(point[2]) + t * by
            })
        };
        let (origin, direction) = (moved(ray.origin, 1.0), moved(ray.direction, 0.0));
        for LeafTriangle { triangle, index } in triangles {
            let [a, b, c] = [triangle.a, triangle.b, triangle.c].map(|vertex| <[f32; 3]>::from(vertex).map(f64::from));
            let (ab, ac, ao) = (minus(b, a), minus(c, a), minus(origin, a));
            let p = cross(direction, ac);
            let determinant = dot(ab, p);
            let q = cross(ao, ab);
            let [u, v, t] = [dot(ao, p), dot(direction, q), dot(ac, q)].map(|number| number / determinant);
            let is_front = determinant > 0.0;
            let culled_by = if is_front { FRONT } else { BACK };
            if ray.flags & culled_by == 0 {
                let margin = u.min(v).min(1.0 - u - v);
                hits.push(Exact { t, instance, triangle: *index, is_front, margin });
            }
        }
    }
    hits
}

/// The nearest hit, if rounding cannot change which it is.
fn certain(scene: &TwoLevelScene, ray: &RayRequest) -> Option<Option<Exact>> {
    const NEAR: f64 = 1e-4;
    let (t_min, t_max) = (f64::from(ray.t_min), f64::from(ray.t_max));
    let all = all_hits(scene, ray);
    let possible = |hit: &&Exact| hit.margin > -NEAR && hit.t > t_min - NEAR && hit.t < t_max + NEAR;
    let near: Vec<&Exact> = all.iter().filter(possible).collect();
    // Copies of an instance or a triangle with the same face have exactly the same distance: the lowest index wins.
    let first =
        near.iter().min_by(|a, b| a.t.total_cmp(&b.t).then((a.instance, a.triangle).cmp(&(b.instance, b.triangle))));
    let Some(&&first) = first else { return Some(None) };
    let is_certain = first.margin > NEAR && first.t > t_min + NEAR && first.t < t_max - NEAR;
    let is_alone = near.iter().all(|hit| (hit.t, hit.is_front) == (first.t, first.is_front) || hit.t > first.t + NEAR);
    (is_certain && is_alone).then_some(Some(first))
}

#[test]
fn hits_are_those_of_every_triangle_in_binary64() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let (mut certainly, mut inside, mut rays) = (0, 0, 0);
    for number in 0..60 {
        let scene = TwoLevelScene::random(NodeKind::ALL[number as usize % 3], 1 + number % 12, false, &mut random);
        for _ in 0..200 {
            let ray = random_ray(scene.root, &mut random);
            let ray = RayRequest { flags: [0, BACK, FRONT][random.random_range(0..3)], ..ray };
            let replies = STACKS.map(|stack| trace(&scene.blocks, stack, &ray));
            assert!(
                replies.iter().all(|reply| format!("{:?}", reply.hit) == format!("{:?}", replies[0].hit)),
                "{ray:?}"
            );
            if replies[0].status == status::REFUSED {
                continue;
            }
            rays += 1;
            let Some(expected) = certain(&scene, &ray) else { continue };
            certainly += 1;
            let of = |instance, triangle| (instance, triangle);
            let found = replies[0].hit.map(|hit| of(hit.instance.map(|instance| instance.index), hit.primitive));
            assert_eq!(found, expected.map(|hit| of(hit.instance, hit.triangle)), "{ray:?} {expected:?}");
            if let (Some(hit), Some(expected)) = (replies[0].hit, expected) {
                inside += u32::from(hit.instance.is_some());
                assert!(
                    (f64::from(hit.t) - expected.t).abs() < 1e-4 * (1.0 + expected.t),
                    "{ray:?} {hit:?} {expected:?}"
                );
            }
            let any =
                trace(&scene.blocks, 8, &RayRequest { flags: ray.flags | ray_flags::TERMINATE_ON_FIRST_HIT, ..ray });
            assert_eq!(any.hit.is_some(), expected.is_some(), "{ray:?}");
        }
    }
    assert!(certainly > rays * 3 / 4 && inside > rays / 8, "{rays} rays, {certainly} certain, {inside} in instances");
}

/// The cycles from the last beat of an instance's block to the next request of its ray, as `docs/reference/unit.md` has
/// them.
#[test]
fn an_instance_takes_as_many_cycles_as_documented() {
    for (node, documented) in [(NodeKind::Wide4, 39), (NodeKind::Quantised, 41), (NodeKind::Wide8, 41)] {
        let mut scene = Scene(Vec::new(), node);
        let object = scene.leaf(&[at(3.0, 0)]);
        let root = scene.instance(&Instance { root: object, ..Instance::default() });
        let step = StepParameters { node, features: INSTANCES, ..StepParameters::default() };
        let bytes = node.block_bytes();
        let parameters = UnitParameters { memory_width: 8 * bytes, step, ..UnitParameters::default() };
        let mut unit = UnitModel::new(&Shape::default(), parameters);
        let (mut requested, mut waiting) = (Vec::new(), None);
        for cycle in 0..200 {
            // A block arrives in the cycle after its request.
            let beat = waiting.take().map(|BlockRequest { address, tag }| {
                let beat = &scene.0[address as usize..][..bytes as usize];
                Response { tag, is_error: false, beat }
            });
            waiting = unit.outputs().request;
            requested.extend(waiting.map(|_| cycle));
            let ray = (cycle == 0).then(|| (0, along_z(root)));
            let inputs =
                UnitInputs { ray, hit_ready: true, request_ready: true, response: beat, ..UnitInputs::default() };
            unit.cycle(&inputs);
        }
        assert_eq!(requested[1] - requested[0] - 1, documented, "{node}");
    }
}

/// The operation against its definition.
#[test]
fn a_transform_rounds_every_product_and_sum() {
    let number = |k: u32| f32::from_bits(0x3f00_0000 + k.wrapping_mul(0x9e37_79b9) % 0x0180_0000);
    for case in 0..1000 {
        let numbers: [f32; 15] = std::array::from_fn(|k| number(15 * case + k as u32) * [1.0, -1.0][k % 2]);
        let (point, matrix) = (&numbers[..3], &numbers[3..]);
        let row = |k: usize| {
            let [x, y, z, t] = [0, 1, 2, 3].map(|column| matrix[4 * k + column].into());
            Row { x, y, z, t }
        };
        let input = TransformInput { point: [point[0], point[1], point[2]].into(), matrix: [row(0), row(1), row(2)] };
        let (outcome, ()) = Transform.run(Binary32, input, ());
        let expected: [f32; 3] = std::array::from_fn(|k| {
            let row = &matrix[4 * k..];
            ((row[0] * point[0] + row[1] * point[1]) + row[2] * point[2]) + row[3]
        });
        assert_eq!(<[f32; 3]>::from(outcome.transformed), expected);
    }
}

/// With the feature, the datapath has the same units in each step.
#[test]
fn the_datapath_needs_no_more_units() {
    let unit = |features| {
        let step = StepParameters { features, ..StepParameters::default() };
        UnitNetlist::new(Config::DEFAULT, UnitParameters { step, ..UnitParameters::default() }).expect("a unit")
    };
    let (with, without) = (unit(INSTANCES), unit(UnitFeatures::OFF));
    for step in 0..without.datapath.steps().count() {
        assert_eq!(with.datapath.units(step), without.datapath.units(step), "step {step}");
    }
    let has_port = |unit: &UnitNetlist| unit.top.port_width("hit_instance_o").is_some();
    assert!(has_port(&with) && !has_port(&without));
}
