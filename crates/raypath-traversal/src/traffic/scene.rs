//! Scenes made block by block, random ones, and random rays.

use crate::blocks::wide8::Node8;
use crate::blocks::{LeafTriangle, NODE_KIND, Node, NodeKind};
use crate::instance::{INSTANCE_KIND, Instance};
use crate::{RayRequest, ray_flags};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use raypath_ops::{Aabb, Binary32, Triangle};

/// The blocks of a scene with these nodes, appended one after another, from address 0 on.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct BlockScene(pub Vec<u8>, pub NodeKind);

/// A tree in a scene.
#[derive(Debug, Clone)]
pub(super) struct Object {
    /// The child word of its root.
    pub root: u32,
    pub bounds: Aabb<Binary32>,
    pub triangles: Vec<LeafTriangle>,
}

impl BlockScene {
    /// The address of the next block.
    pub fn address(&self) -> u32 {
        self.0.len() as u32
    }

    /// Appends a leaf, and returns its child word. The word is valid for 1 to 8 triangles. Of compressed nodes it is a
    /// node, if there are more than a leaf holds.
    pub fn leaf(&mut self, triangles: &[LeafTriangle]) -> u32 {
        let most = self.1.max_leaf() as usize;
        if triangles.len() > most {
            let (mut boxes, mut children) = ([never(); 4], [0; 4]);
            for (place, part) in triangles.chunks(most).enumerate() {
                (boxes[place], children[place]) = (around(part), self.leaf(part));
            }
            return self.node(boxes, children);
        }
        let (address, (blocks, places)) = (self.address(), LeafTriangle::to_blocks(triangles, 0, self.1));
        self.0.extend(blocks);
        address | places
    }

    /// Appends a node, and returns its child word. A compressed node whose boxes cannot be contained becomes one without
    /// children.
    pub fn node(&mut self, boxes: [Aabb<Binary32>; 4], children: [u32; 4]) -> u32 {
        let node = Node { boxes, children };
        let bytes = match self.1 {
            NodeKind::Wide4 => node.to_bytes().to_vec(),
            NodeKind::Quantised => node.to_quantised_bytes().unwrap_or([0; 64]).to_vec(),
            NodeKind::Wide8 => return self.eight(&boxes, &children),
        };
        let word = self.address() | NODE_KIND;
        self.0.extend(bytes);
        word
    }

    /// Appends a node of up to eight children, and copies of them before it, because they must be consecutive.
    fn eight(&mut self, boxes: &[Aabb<Binary32>], children: &[u32]) -> u32 {
        let bytes = self.1.block_bytes() as usize;
        let mut node = Node8 { boxes: [never(); 8], children: [0; 8] };
        for copies_nodes in [true, false] {
            for (place, &word) in children.iter().enumerate().filter(|(_, word)| **word != 0) {
                if (word % bytes as u32 == NODE_KIND) == copies_nodes {
                    node.children[place] = self.address() | (word % bytes as u32);
                    node.boxes[place] = boxes[place];
                    let first = (word as usize / bytes * bytes).min(self.0.len());
                    self.0.extend_from_within(first..(first + bytes).min(self.0.len()));
                    self.0.resize(self.0.len().next_multiple_of(bytes), 0);
                }
            }
        }
        let word = self.address() | NODE_KIND;
        self.0.extend(node.to_bytes().unwrap_or([0; 128]));
        word
    }

    /// Appends an instance, and returns its child word.
    pub fn instance(&mut self, instance: &Instance) -> u32 {
        let word = self.address() | INSTANCE_KIND;
        self.0.extend(instance.to_bytes(self.1));
        word
    }

    /// A tree over random triangles in a cube from -1 to 1, and the child word of its root. Some triangles lie on
    /// others, with either face towards a ray.
    pub fn random(triangles: u32, random: &mut ChaCha8Rng) -> (Self, u32) {
        Self::random_of(NodeKind::Wide4, triangles, random)
    }

    /// The same with these nodes. The tree does not depend on them.
    pub fn random_of(nodes: NodeKind, triangles: u32, random: &mut ChaCha8Rng) -> (Self, u32) {
        let mut scene = Self(Vec::new(), nodes);
        let Object { root, .. } = scene.random_object(triangles, random);
        (scene, root)
    }

    /// Appends a tree over random triangles in a cube from -1 to 1.
    pub(super) fn random_object(&mut self, triangles: u32, random: &mut ChaCha8Rng) -> Object {
        let mut all: Vec<LeafTriangle> = (0..triangles)
            .map(|index| {
                let at: [f32; 3] = std::array::from_fn(|_| random.random_range(-1.0..1.0));
                let mut corner = || std::array::from_fn(|axis| at[axis] + random.random_range(-0.25_f32..0.25));
                LeafTriangle { triangle: Triangle::new(corner(), corner(), corner()), index }
            })
            .collect();
        for place in 1..all.len() {
            match random.random_range(0..8) {
                0 => {
                    let Triangle { a, b, c } = all[random.random_range(0..place)].triangle;
                    let is_turned = random.random();
                    all[place].triangle = if is_turned { Triangle { a, b: c, c: b } } else { Triangle { a, b, c } };
                }
                1..=4 => {
                    // At an edge of the one before it.
                    let [own, ..] = all[place].corners();
                    let mut corners = all[place - 1].corners();
                    corners[random.random_range(0..3)] = own;
                    corners.rotate_left(random.random_range(0..3));
                    let [a, b, c] = corners;
                    all[place].triangle = Triangle::new(a, b, c);
                }
                _ => {}
            }
        }
        let (root, bounds) = self.tree(&mut all, random);
        Object { root, bounds, triangles: all }
    }

    /// A path of this many nodes whose boxes are all the same, so that every level is pending at its end, with a
    /// leaf of a random triangle once to three times at each; and the child word of its root.
    pub fn deep(depth: u32, random: &mut ChaCha8Rng) -> (Self, u32) {
        Self::deep_of(NodeKind::Wide4, depth, random)
    }

    /// The same with these nodes.
    pub fn deep_of(nodes: NodeKind, depth: u32, random: &mut ChaCha8Rng) -> (Self, u32) {
        let mut scene = Self(Vec::new(), nodes);
        let Object { root, .. } = scene.deep_object(depth, random);
        (scene, root)
    }

    /// Appends such a path.
    pub(super) fn deep_object(&mut self, depth: u32, random: &mut ChaCha8Rng) -> Object {
        let all = Aabb::new([-2.0; 3], [2.0; 3]);
        let (mut next, mut triangles) = (None, Vec::new());
        for level in 0..depth {
            let mut corner = || std::array::from_fn(|_| random.random_range(-1.5_f32..1.5));
            let triangle = Triangle::new(corner(), corner(), corner());
            triangles.push(LeafTriangle { triangle, index: level });
            let leaf = self.leaf(&triangles[level as usize..]);
            let place = random.random_range(0..4);
            let (mut boxes, mut children) = ([never(); 4], [0; 4]);
            (boxes[place], children[place]) = (all, next.unwrap_or(leaf));
            if next.is_some() {
                for other in 1..1 + random.random_range(1..4) {
                    let other = (place + other) % 4;
                    (boxes[other], children[other]) = (all, leaf);
                }
            }
            next = Some(self.node(boxes, children));
        }
        Object { root: next.unwrap_or(0), bounds: all, triangles }
    }

    fn tree(&mut self, triangles: &mut [LeafTriangle], random: &mut ChaCha8Rng) -> (u32, Aabb<Binary32>) {
        if triangles.is_empty() {
            return (0, never());
        }
        let size = random.random_range(1..9);
        if triangles.len() <= size {
            return (self.leaf(triangles), around(triangles));
        }
        let axis = random.random_range(0..3);
        triangles.sort_by(|a, b| a.corners()[0][axis].total_cmp(&b.corners()[0][axis]));
        let (mut boxes, mut children) = ([never(); 8], [0; 8]);
        let count = random.random_range(2..=self.1.children());
        let chunk = triangles.len().div_ceil(count);
        for (place, part) in triangles.chunks_mut(chunk).enumerate() {
            (children[place], boxes[place]) = self.tree(part, random);
        }
        let whole = around(triangles);
        let word = match (boxes.first_chunk(), children.first_chunk()) {
            (Some(boxes), Some(children)) if self.1 != NodeKind::Wide8 => self.node(*boxes, *children),
            _ => self.eight(&boxes, &children),
        };
        (word, whole)
    }
}

/// The box that no ray hits: that of a missing child.
pub fn never() -> Aabb<Binary32> {
    Aabb::new([f32::INFINITY; 3], [f32::NEG_INFINITY; 3])
}

fn around(triangles: &[LeafTriangle]) -> Aabb<Binary32> {
    let all: Vec<[f32; 3]> = triangles.iter().flat_map(LeafTriangle::corners).collect();
    let bound =
        |pick: fn(f32, f32) -> f32, from: f32, axis: usize| all.iter().map(|corner| corner[axis]).fold(from, pick);
    let least = [0, 1, 2].map(|axis| bound(f32::min, f32::INFINITY, axis));
    Aabb::new(least, [0, 1, 2].map(|axis| bound(f32::max, f32::NEG_INFINITY, axis)))
}

/// A ray through the cube, or one of the odd ones: refused, along an axis, short, of any kind of hit.
pub fn random_ray(root: u32, random: &mut ChaCha8Rng) -> RayRequest {
    let mut point = |scale: f32| -> [f32; 3] { std::array::from_fn(|_| random.random_range(-scale..scale)) };
    let (mut origin, target) = (point(3.0), point(1.0));
    let mut direction: [f32; 3] = std::array::from_fn(|axis| target[axis] - origin[axis]);
    if random.random_range(0..8) == 0 {
        let axis = random.random_range(0..3);
        direction = std::array::from_fn(|other| if other == axis { direction[axis] } else { 0.0 });
    }
    let odd = [0.0, -0.0, f32::NAN, f32::INFINITY, 1e-40, -1.0];
    if random.random_range(0..16) == 0 {
        direction[random.random_range(0..3)] = odd[random.random_range(0..odd.len())];
    }
    if random.random_range(0..16) == 0 {
        origin[random.random_range(0..3)] = odd[random.random_range(0..odd.len())];
    }
    let mut one_of = |common: f32, count: u32| {
        let is_odd = random.random_range(0..count) == 0;
        if is_odd { odd[random.random_range(0..odd.len())] } else { common }
    };
    let (t_min, t_max) = (one_of(0.0, 16), one_of(f32::INFINITY, 16));
    let t_max = if random.random_range(0..4) == 0 { random.random_range(0.1..3.0) } else { t_max };
    RayRequest {
        origin,
        direction,
        t_min,
        t_max,
        flags: random_flags(random),
        cull_mask: if random.random() { u8::MAX } else { random.random() },
        root,
        base: 0,
    }
}

/// Flags of a ray, which seldom have no meaning.
fn random_flags(random: &mut ChaCha8Rng) -> u32 {
    let mut one_of =
        |flags: [u32; 4]| if random.random_range(0..3) != 0 { 0 } else { flags[random.random_range(0..4)] };
    let opacity = one_of([ray_flags::OPAQUE, ray_flags::NO_OPAQUE, ray_flags::CULL_OPAQUE, ray_flags::CULL_NO_OPAQUE]);
    let (back, front) = (ray_flags::CULL_BACK_FACING_TRIANGLES, ray_flags::CULL_FRONT_FACING_TRIANGLES);
    let faces = one_of([back, front, back, front]);
    let ends = one_of([ray_flags::TERMINATE_ON_FIRST_HIT; 4]);
    let odd = match random.random_range(0..16) {
        0 => random.random::<u32>() & ray_flags::ALL,
        1 => 1 << random.random_range(0..10),
        _ => 0,
    };
    opacity | faces | ends | odd
}
