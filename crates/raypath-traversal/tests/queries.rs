//! Opacity, masks and flags, against the rules of Vulkan and DirectX written down once more, for every triangle in
//! binary64.

use crate::common::{along_z, at, cross, dot, minus};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_model::Shape;
use raypath_ops::{Aabb, Rules};
use raypath_traversal::blocks::{Child, LeafTriangle, NodeKind};
use raypath_traversal::state::status;
use raypath_traversal::traffic::{BlockScene, never, random_ray};
use raypath_traversal::{
    Candidate, Front, Hit, HitInstance, Instance, Queries, RayRequest, Response, StepParameters, Unit, UnitEngine,
    UnitFeatures, UnitInputs, UnitModel, UnitOutputs, UnitParameters, Verdict, instance_flags, ray_flags,
};
use std::collections::BTreeSet;

/// A geometry of one leaf.
#[derive(Debug, Clone)]
struct Geometry {
    index: u32,
    is_opaque: bool,
    triangles: Vec<LeafTriangle>,
}

/// Geometries that lie in the scene itself, or in an instance.
#[derive(Debug, Clone)]
struct Object {
    instance: Option<Instance>,
    geometries: Vec<Geometry>,
}

/// Appends a leaf of a geometry, and returns its child word.
fn leaf(scene: &mut BlockScene, geometry: &Geometry) -> u32 {
    let Geometry { index, is_opaque, triangles } = geometry;
    let leaf = Child::Leaf { address: scene.address(), count: triangles.len() as u32, is_opaque: *is_opaque };
    scene.0.extend(LeafTriangle::to_blocks(triangles, *index, NodeKind::Wide4).0);
    leaf.word(NodeKind::Wide4).expect("a leaf")
}

/// A node over up to four children, all of which every ray visits.
fn over(scene: &mut BlockScene, of: &[u32]) -> u32 {
    let (mut boxes, mut children) = ([never(); 4], [0; 4]);
    boxes[..of.len()].fill(Aabb::new([-100.0; 3], [100.0; 3]));
    children[..of.len()].copy_from_slice(of);
    scene.node(boxes, children)
}

/// The scene of these objects, and its root.
fn scene_of(objects: &mut [Object]) -> (BlockScene, u32) {
    let mut scene = BlockScene::default();
    let mut words: Vec<u32> = Vec::new();
    for Object { instance, geometries } in objects {
        let leaves: Vec<u32> = geometries.iter().map(|geometry| leaf(&mut scene, geometry)).collect();
        let root = over(&mut scene, &leaves);
        words.push(match instance {
            None => root,
            Some(instance) => {
                instance.root = root;
                scene.instance(instance)
            }
        });
    }
    while words.len() > 1 {
        words = words.chunks(4).map(|four| over(&mut scene, four)).collect();
    }
    (scene, words[0])
}

/// What the rules say of a triangle that the ray meets.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Met {
    t: f64,
    /// The least weight of a vertex: how far the ray is inside of the triangle.
    margin: f64,
    instance: Option<HitInstance>,
    geometry: u32,
    primitive: u32,
    back_face: bool,
    is_opaque: bool,
}

/// A point, or a direction with a translation by 0, in the space of an object.
fn moved(to_object: [[f32; 4]; 3], point: [f32; 3], by: f64) -> [f64; 3] {
    to_object.map(|row| (0..3).map(|k| f64::from(row[k]) * f64::from(point[k])).sum::<f64>() + f64::from(row[3]) * by)
}

/// Checks the ray that a candidate in this instance shows: as it entered the unit, or within the rounding of the
/// transform, at most four roundings of each term.
fn check_ray(candidate: &Candidate, ray: &RayRequest, instance: Option<Instance>) {
    let Candidate { origin, direction, .. } = *candidate;
    for (found, given, by) in [(origin, ray.origin, 1.0), (direction, ray.direction, 0.0)] {
        let Some(Instance { to_object, .. }) = instance else {
            assert_eq!(found.map(f32::to_bits), given.map(f32::to_bits), "{ray:?}");
            continue;
        };
        let (exact, terms) =
            (moved(to_object, given, by), moved(to_object.map(|row| row.map(f32::abs)), given.map(f32::abs), by));
        for k in 0..3 {
            let bound = 4.001 * f64::from(f32::EPSILON / 2.0) * terms[k] + 1e-44;
            assert!((f64::from(found[k]) - exact[k]).abs() <= bound, "{ray:?}, {instance:?}: {found:?}, {exact:?}");
        }
    }
}

/// The triangles that count, where the ray meets their planes.
fn met(objects: &[Object], ray: &RayRequest, front: Front) -> Vec<Met> {
    let has = |flag: u32| ray.flags & flag != 0;
    let mut all = Vec::new();
    for Object { instance, geometries } in objects {
        let of = |flag: u32| instance.is_some_and(|instance| u32::from(instance.flags) & flag != 0);
        if instance.is_some_and(|instance| instance.mask & ray.cull_mask == 0) || has(ray_flags::SKIP_TRIANGLES) {
            continue;
        }
        let to_object = instance.map_or(Instance::default().to_object, |instance| instance.to_object);
        let (origin, direction) = (moved(to_object, ray.origin, 1.0), moved(to_object, ray.direction, 0.0));
        for Geometry { index, is_opaque, triangles } in geometries {
            let mut is_opaque = *is_opaque;
            for (flag, value) in [(instance_flags::FORCE_OPAQUE, true), (instance_flags::FORCE_NO_OPAQUE, false)] {
                is_opaque = if of(flag) { value } else { is_opaque };
            }
            for (flag, value) in [(ray_flags::OPAQUE, true), (ray_flags::NO_OPAQUE, false)] {
                is_opaque = if has(flag) { value } else { is_opaque };
            }
            if has(if is_opaque { ray_flags::CULL_OPAQUE } else { ray_flags::CULL_NO_OPAQUE }) {
                continue;
            }
            for LeafTriangle { triangle, index: primitive } in triangles {
                let corners = [triangle.a, triangle.b, triangle.c];
                let [a, b, c] = corners.map(|vertex| <[f32; 3]>::from(vertex).map(f64::from));
                let (ab, ac, ao) = (minus(b, a), minus(c, a), minus(origin, a));
                let p = cross(direction, ac);
                let determinant = dot(ab, p);
                let q = cross(ao, ab);
                let [u, v, t] = [dot(ao, p), dot(direction, q), dot(ac, q)].map(|number| number / determinant);
                let is_counter_clockwise = determinant > 0.0;
                let is_front =
                    (is_counter_clockwise == (front == Front::CounterClockwise)) != of(instance_flags::FLIP_FACING);
                let (back, front) = (ray_flags::CULL_BACK_FACING_TRIANGLES, ray_flags::CULL_FRONT_FACING_TRIANGLES);
                let is_culled = has(if is_front { front } else { back }) && !of(instance_flags::FACING_CULL_DISABLE);
                if !is_culled {
                    let words = |&Instance { index, custom_index, shader_offset, .. }: &Instance| HitInstance {
                        index,
                        custom_index,
                        shader_offset,
                    };
                    all.push(Met {
                        t,
                        margin: u.min(v).min(1.0 - u - v),
                        instance: instance.as_ref().map(words),
                        geometry: *index,
                        primitive: *primitive,
                        back_face: !is_front,
                        is_opaque,
                    });
                }
            }
        }
    }
    all
}

fn random_objects(random: &mut ChaCha8Rng) -> Vec<Object> {
    let geometry = |index: u32, random: &mut ChaCha8Rng| {
        let count = [1, 2, 3, 5][random.random_range(0..4)];
        let mut corner = || std::array::from_fn(|_| random.random_range(-1.5_f32..1.5));
        let triangles = (0..count)
            .map(|index| LeafTriangle { triangle: raypath_ops::Triangle::new(corner(), corner(), corner()), index });
        let triangles = triangles.collect();
        Geometry { index, is_opaque: random.random(), triangles }
    };
    (0..random.random_range(1..9))
        .map(|index| {
            let geometries = (0..random.random_range(1..5)).map(|place| geometry(8 * index + place, random)).collect();
            let mut row = || {
                let linear: [f64; 3] = std::array::from_fn(|_| random.random_range(-0.9..0.9));
                [linear[0], linear[1], linear[2], random.random_range(-1.0..1.0)]
            };
            let placed = Instance::placed([row(), row(), row()], 0, index);
            let is_tame = |instance: &Instance| instance.to_object.as_flattened().iter().all(|x| x.abs() < 8.0);
            let instance = placed.filter(is_tame).map(|instance| Instance {
                custom_index: random.random_range(0..1 << 24),
                mask: 1 << random.random_range(0..3),
                shader_offset: random.random_range(0..1 << 24),
                flags: [0, 1, 2, 3, 4, 8][random.random_range(0..6)],
                ..instance
            });
            Object { instance, geometries }
        })
        .collect()
}

#[test]
fn hits_are_those_of_the_rules() {
    const NEAR: f64 = 1e-4;
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let (mut rays, mut certain, mut hits, mut in_instances, mut candidates) = (0, 0, 0, 0, 0);
    let mut asked_in_instances = 0;
    let is_accepted = |primitive: u32| primitive.is_multiple_of(2);
    for number in 0..200 {
        let mut objects = random_objects(&mut random);
        let (scene, root) = scene_of(&mut objects);
        let front = [Front::CounterClockwise, Front::Clockwise][number % 2];
        let queries = [Queries::Flags, Queries::Full][number / 2 % 2];
        let features = UnitFeatures { instances: true, queries, ..UnitFeatures::OFF };
        let stack = [2, 4, 8, 32][number / 4 % 4];
        let step = StepParameters { stack, features, front, ..StepParameters::default() };
        let mut unit = Unit::new(Rules::Paper, step);
        for _ in 0..100 {
            let ray = RayRequest { cull_mask: random.random_range(1..8), ..random_ray(root, &mut random) };
            let mut asked = Vec::new();
            let reply = unit.trace_with(&scene.0[..], &ray, &mut |candidate: &Candidate| {
                let Hit { instance, geometry, primitive, back_face, .. } = candidate.hit;
                asked.push((instance, geometry, primitive, back_face));
                check_ray(candidate, &ray, instance.and_then(|place| objects[place.index as usize].instance));
                asked_in_instances += u32::from(instance.is_some());
                Verdict { accepts: is_accepted(primitive), ..Verdict::IGNORE }
            });
            assert!(reply.status <= status::REFUSED, "{reply:?}");
            let ends = ray.flags & ray_flags::TERMINATE_ON_FIRST_HIT != 0;
            if reply.status == status::REFUSED {
                continue;
            }
            rays += 1;
            let (t_min, t_max) = (f64::from(ray.t_min), f64::from(ray.t_max));
            let mut near = met(&objects, &ray, front);
            near.retain(|met| met.margin > -NEAR && met.t > t_min - NEAR && met.t < t_max + NEAR);
            near.sort_by(|a, b| a.t.total_cmp(&b.t));
            let is_clear = |met: &Met| met.margin > NEAR && met.t > t_min + NEAR && met.t < t_max - NEAR;
            if !near.iter().all(is_clear) || near.windows(2).any(|pair| pair[1].t < pair[0].t + NEAR) {
                continue;
            }
            certain += 1;
            if queries == Queries::Full {
                let all: BTreeSet<_> = asked.iter().map(|asked| format!("{asked:?}")).collect();
                assert_eq!(all.len(), asked.len(), "{ray:?}: asked twice about one of {asked:?}");
                let mut met_candidates = 0;
                let end = reply.hit.map_or(f64::INFINITY, |hit| f64::from(hit.t));
                for met in near.iter().filter(|met| !met.is_opaque) {
                    let name = format!("{:?}", (met.instance, met.geometry, met.primitive, met.back_face));
                    assert!(ends || met.t > end - NEAR || all.contains(&name), "{ray:?}: not asked about {met:?}");
                    met_candidates += usize::from(all.contains(&name));
                }
                candidates += met_candidates;
                assert_eq!(met_candidates, asked.len(), "{ray:?}: asked about one that it does not meet");
                near.retain(|met| met.is_opaque || is_accepted(met.primitive));
            }
            let found = reply.hit.map(|hit| (hit.instance, hit.geometry, hit.primitive, hit.back_face));
            let mut allowed = near.iter().map(|met| (met.instance, met.geometry, met.primitive, met.back_face));
            if ends {
                assert!(found.map_or(near.is_empty(), |found| allowed.any(|met| met == found)), "{ray:?} {found:?}");
            } else {
                assert_eq!(found, allowed.next(), "{ray:?}");
            }
            hits += u32::from(found.is_some());
            in_instances += u32::from(found.is_some_and(|(instance, ..)| instance.is_some()));
        }
    }
    assert!(certain > rays * 3 / 4 && hits > 2000 && in_instances > 1000, "{rays}, {certain}, {hits}, {in_instances}");
    assert!(candidates > 500 && asked_in_instances > 250, "{candidates} candidates, {asked_in_instances}");
}

/// Combinations that the APIs do not have are refused, and the others are not.
#[test]
fn flags_without_a_meaning_are_refused() {
    let mut scene = BlockScene::default();
    let root = scene.leaf(&[at(3.0, 0)]);
    let mut unit = Unit::new(Rules::Paper, StepParameters::default());
    for flags in 0..=ray_flags::ALL {
        let set = |names: &[u32]| names.iter().filter(|&flag| flags & flag != 0).count();
        let opacity = [ray_flags::OPAQUE, ray_flags::NO_OPAQUE, ray_flags::CULL_OPAQUE, ray_flags::CULL_NO_OPAQUE];
        let (back, front) = (ray_flags::CULL_BACK_FACING_TRIANGLES, ray_flags::CULL_FRONT_FACING_TRIANGLES);
        let is_refused = set(&opacity) > 1
            || set(&[back, front, ray_flags::SKIP_TRIANGLES]) > 1
            || set(&[ray_flags::SKIP_TRIANGLES, ray_flags::SKIP_AABBS]) > 1;
        let reply = unit.trace(&scene.0[..], &RayRequest { flags, ..along_z(root) });
        assert_eq!(reply.status == status::REFUSED, is_refused, "flags {flags:#b}");
    }
}

/// The cycles from the last beat of a block to its candidate, and from the answer to the hit, as
/// `docs/reference/unit.md` has them.
#[test]
fn a_candidate_takes_as_many_cycles_as_documented() {
    let mut scene = BlockScene::default();
    let triangles = vec![at(3.0, 0)];
    let root = leaf(&mut scene, &Geometry { index: 0, is_opaque: false, triangles });
    let features = UnitFeatures { queries: Queries::Full, ..UnitFeatures::OFF };
    let step = StepParameters { features, ..StepParameters::default() };
    let parameters = UnitParameters { memory_width: 1024, step, ..UnitParameters::default() };
    let mut unit = UnitModel::new(&Shape::default(), parameters);
    let (mut block, mut arrived, mut asked, mut verdict) = (None, 0, 0, None);
    for cycle in 0..500 {
        let UnitOutputs { hit, candidate, request, .. } = unit.outputs();
        let response = block.take().map(|tag| Response { tag, is_error: false, beat: &scene.0[..] });
        arrived = if response.is_some() { cycle } else { arrived };
        asked = if candidate.is_some() { cycle } else { asked };
        if let Some((_, reply)) = hit {
            assert_eq!((reply.status, asked - arrived - 1, cycle - asked - 2), (status::HIT, 33, 6));
            return;
        }
        let ray = (cycle == 0).then(|| (0, along_z(root)));
        let (candidate_ready, request_ready, hit_ready) = (true, true, true);
        unit.cycle(&UnitInputs {
            ray,
            hit_ready,
            candidate_ready,
            verdict,
            request_ready,
            response,
            ..UnitInputs::default()
        });
        // A verdict in the cycle after the candidate.
        verdict = candidate.map(|asked| (asked.tag, Verdict::ACCEPT));
        block = request.map(|request| request.tag);
    }
    panic!("the ray has not ended");
}
