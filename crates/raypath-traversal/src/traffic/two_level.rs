//! Random scenes of two levels: objects, and instances of them.

use super::scene::{BlockScene, Object, never};
use crate::blocks::{LeafTriangle, NodeKind};
use crate::instance::Instance;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use raypath_ops::{Aabb, Binary32, Slab};

/// A scene with instances.
#[derive(Debug, Clone)]
pub struct TwoLevelScene {
    /// The blocks.
    pub blocks: BlockScene,
    /// The child word of the root.
    pub root: u32,
    /// The triangles that are in no instance.
    pub outside: Vec<LeafTriangle>,
    /// The instances, with the triangles of their objects.
    pub instances: Vec<(Instance, Vec<LeafTriangle>)>,
}

/// A part of the upper level: its child word and its box.
type Part = (u32, Aabb<Binary32>);

impl TwoLevelScene {
    /// A scene of these nodes with this number of instances around the origin: turned, sheared, mirrored, and some twice at the same
    /// place. If `is_odd`, some have matrices without an inverse, with huge numbers or NaN, or no
    /// valid object, or that of a part of the scene, such as another instance, or several parts.
    pub fn random(nodes: NodeKind, count: u32, is_odd: bool, random: &mut ChaCha8Rng) -> Self {
        let mut blocks = BlockScene(Vec::new(), nodes);
        let objects: Vec<Object> = (0..random.random_range(1..4))
            .map(|_| match random.random_range(0..4) {
                0 => blocks.deep_object(random.random_range(4..16), random),
                _ => blocks.random_object(random.random_range(1..40), random),
            })
            .collect();
        let loose = blocks.random_object(random.random_range(1..12), random);
        let mut parts: Vec<Part> = vec![(loose.root, loose.bounds)];
        let mut instances: Vec<(Instance, Vec<LeafTriangle>)> = Vec::new();
        // The last have the lowest indices.
        for index in (0..count).rev() {
            let object = &objects[random.random_range(0..objects.len())];
            let (mut instance, mut bounds) = placed(object, index, random);
            let mut triangles = object.triangles.clone();
            let before = instances.last().zip(parts.last()).filter(|_| random.random_range(0..4) == 0);
            if let Some(((same, of_same), part)) = before {
                (instance, bounds, triangles) = (Instance { index, ..*same }, part.1, of_same.clone());
            }
            if is_odd && random.random_range(0..6) == 0 {
                let other = parts[random.random_range(0..parts.len())].0;
                (instance, bounds) = (odd(instance, other, random), Aabb::new([-2.0; 3], [2.0; 3]));
            }
            if is_odd && random.random_range(0..4) == 0 {
                let few: Vec<Part> = (0..3).map(|_| parts[random.random_range(0..parts.len())]).collect();
                (instance.root, _) = blocks.upper(&few, random);
                bounds = Aabb::new([-2.0; 3], [2.0; 3]);
            }
            parts.push((blocks.instance(&instance), bounds));
            instances.push((instance, triangles));
        }
        parts.shuffle(random);
        let (root, _) = blocks.upper(&parts, random);
        Self { blocks, root, outside: loose.triangles, instances }
    }
}

impl BlockScene {
    /// A tree over parts.
    fn upper(&mut self, parts: &[Part], random: &mut ChaCha8Rng) -> Part {
        if let [part] = parts {
            return *part;
        }
        let (mut boxes, mut children) = ([never(); 4], [0; 4]);
        let chunk = parts.len().div_ceil(random.random_range(2..5));
        for (place, parts) in parts.chunks(chunk).enumerate() {
            (children[place], boxes[place]) = self.upper(parts, random);
        }
        (self.node(boxes, children), around(&boxes))
    }
}

/// An instance of an object at a random place, and its box in the scene.
fn placed(object: &Object, index: u32, random: &mut ChaCha8Rng) -> (Instance, Aabb<Binary32>) {
    loop {
        let mut row = || {
            let linear: [f64; 3] = std::array::from_fn(|_| random.random_range(-0.8..0.8));
            [linear[0], linear[1], linear[2], random.random_range(-1.0..1.0)]
        };
        let to_scene = [row(), row(), row()];
        let instance = Instance::placed(to_scene, object.root, index);
        let is_tame = |instance: &Instance| instance.to_object.as_flattened().iter().all(|number| number.abs() < 8.0);
        if let Some(instance) = instance.filter(is_tame) {
            return (instance, moved(object.bounds, to_scene));
        }
    }
}

/// A box around a box that a matrix moves.
fn moved(bounds: Aabb<Binary32>, to_scene: [[f64; 4]; 3]) -> Aabb<Binary32> {
    let slabs = [bounds.x, bounds.y, bounds.z].map(ends);
    let ends = to_scene.map(|[x, y, z, t]| {
        let mut ends = [t - 1e-3, t + 1e-3];
        for (factor, slab) in [x, y, z].into_iter().zip(slabs) {
            let products = slab.map(|end| factor * f64::from(end));
            ends[0] += products[0].min(products[1]);
            ends[1] += products[0].max(products[1]);
        }
        ends.map(|end| end as f32)
    });
    Aabb::new(ends.map(|ends| ends[0]), ends.map(|ends| ends[1]))
}

fn around(boxes: &[Aabb<Binary32>]) -> Aabb<Binary32> {
    let of = |slab: fn(&Aabb<Binary32>) -> Slab<Binary32>| {
        let all = boxes.iter().map(|aabb| ends(slab(aabb)));
        all.fold([f32::INFINITY, f32::NEG_INFINITY], |[least, greatest], [min, max]| {
            [least.min(min), greatest.max(max)]
        })
    };
    let ends = [of(|aabb| aabb.x), of(|aabb| aabb.y), of(|aabb| aabb.z)];
    Aabb::new(ends.map(|ends| ends[0]), ends.map(|ends| ends[1]))
}

fn ends(slab: Slab<Binary32>) -> [f32; 2] {
    [slab.min, slab.max].map(f32::from)
}

/// An instance that rays may not enter, or that they enter with odd constants.
fn odd(instance: Instance, other: u32, random: &mut ChaCha8Rng) -> Instance {
    let Instance { mut to_object, mut root, .. } = instance;
    let place = random.random_range(0..12);
    let numbers = [f32::NAN, f32::INFINITY, f32::MAX, 1e30, 1e-40];
    let scale = |to_object: [[f32; 4]; 3], by: f32| to_object.map(|row| row.map(|number| number * by));
    match random.random_range(0..7) {
        0 => to_object = [[0.0; 4]; 3],
        1 => to_object[1] = to_object[0],
        2 => to_object = scale(to_object, 1e37),
        3 => to_object = scale(to_object, 1e-42),
        4 => to_object.as_flattened_mut()[place] = numbers[random.random_range(0..numbers.len())],
        5 => root = [0, 63, 0x4000_0020][random.random_range(0..3)],
        _ => root = other,
    }
    Instance { to_object, root, ..instance }
}
