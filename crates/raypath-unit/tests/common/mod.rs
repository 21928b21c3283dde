//! Rays, scenes and a memory for tests of the unit.
#![allow(dead_code, reason = "each test binary uses a part")]

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_ops::{Aabb, Binary32, Triangle};
use raypath_unit::blocks::{BLOCK_BYTES, Child, LeafTriangle, Node};
use raypath_unit::{BlockRequest, Memory, RayRequest, Reply, Response, UnitEngine, UnitInputs};
use std::collections::BTreeMap;

/// Blocks, appended one after another.
#[derive(Default)]
pub struct Scene(pub Vec<u8>);

impl Scene {
    pub fn address(&self) -> u32 {
        self.0.len() as u32
    }

    pub fn leaf(&mut self, triangles: &[LeafTriangle]) -> u32 {
        let child = Child::Leaf { address: self.address(), count: triangles.len() as u32 };
        self.0.extend(LeafTriangle::to_bytes(triangles));
        child.word().expect("a leaf")
    }

    pub fn node(&mut self, boxes: [Aabb<Binary32>; 4], children: [u32; 4]) -> u32 {
        let child = Child::Node { address: self.address() };
        self.0.extend(Node { boxes, children }.to_bytes());
        child.word().expect("a node")
    }

    /// A tree over random triangles in a cube from -1 to 1, and the child word of its root.
    pub fn random(triangles: u32, random: &mut ChaCha8Rng) -> (Self, u32) {
        let mut scene = Self::default();
        let mut all: Vec<LeafTriangle> = (0..triangles)
            .map(|index| {
                let at: [f32; 3] = std::array::from_fn(|_| random.random_range(-1.0..1.0));
                let mut corner = || std::array::from_fn(|axis| at[axis] + random.random_range(-0.25_f32..0.25));
                LeafTriangle { triangle: Triangle::new(corner(), corner(), corner()), index }
            })
            .collect();
        let (root, _) = scene.tree(&mut all, random);
        (scene, root)
    }

    fn tree(&mut self, triangles: &mut [LeafTriangle], random: &mut ChaCha8Rng) -> (u32, Aabb<Binary32>) {
        let size = random.random_range(1..9);
        if triangles.len() <= size {
            return (self.leaf(triangles), around(triangles));
        }
        let axis = random.random_range(0..3);
        triangles.sort_by(|a, b| center(a)[axis].total_cmp(&center(b)[axis]));
        let (mut boxes, mut children) = ([never(); 4], [0; 4]);
        let count = random.random_range(2..5);
        let chunk = triangles.len().div_ceil(count);
        for (place, part) in triangles.chunks_mut(chunk).enumerate() {
            (children[place], boxes[place]) = self.tree(part, random);
        }
        let whole = around(triangles);
        (self.node(boxes, children), whole)
    }
}

pub fn never() -> Aabb<Binary32> {
    Aabb::new([f32::INFINITY; 3], [f32::NEG_INFINITY; 3])
}

fn corners(LeafTriangle { triangle: Triangle { a, b, c }, .. }: &LeafTriangle) -> [[f32; 3]; 3] {
    [a, b, c].map(|vertex| (*vertex).into())
}

fn center(triangle: &LeafTriangle) -> [f32; 3] {
    corners(triangle)[0]
}

fn around(triangles: &[LeafTriangle]) -> Aabb<Binary32> {
    let all: Vec<[f32; 3]> = triangles.iter().flat_map(corners).collect();
    let bound =
        |pick: fn(f32, f32) -> f32, axis: usize| all.iter().map(|corner| corner[axis]).reduce(pick).expect("one");
    Aabb::new([0, 1, 2].map(|axis| bound(f32::min, axis)), [0, 1, 2].map(|axis| bound(f32::max, axis)))
}

/// A ray through the cube, or one of the odd ones: refused, along an axis, short, of any kind of hit.
pub fn ray(root: u32, random: &mut ChaCha8Rng) -> RayRequest {
    let mut point = |scale: f32| -> [f32; 3] { std::array::from_fn(|_| random.random_range(-scale..scale)) };
    let (origin, target) = (point(3.0), point(1.0));
    let mut direction: [f32; 3] = std::array::from_fn(|axis| target[axis] - origin[axis]);
    if random.random_range(0..8) == 0 {
        let axis = random.random_range(0..3);
        direction = std::array::from_fn(|other| if other == axis { direction[axis] } else { 0.0 });
    }
    let odd = [0.0, -0.0, f32::NAN, f32::INFINITY, 1e-40, -1.0];
    if random.random_range(0..16) == 0 {
        direction[random.random_range(0..3)] = odd[random.random_range(0..odd.len())];
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
        any_hit: random.random_range(0..4) == 0,
        cull_back: random.random_range(0..4) == 0,
        cull_front: random.random_range(0..4) == 0,
        root,
    }
}

/// How a memory and the users of the other channels behave.
#[derive(Debug, Clone, Copy)]
pub struct Behaviour {
    /// The least and greatest cycles from a request to the first beat.
    pub latency: (u64, u64),
    /// The share of cycles in which each channel stalls, in 256ths: rays, hits, requests, responses.
    pub stalls: [u32; 4],
    /// The share of beats with an error, in 65,536ths.
    pub errors: u32,
}

/// A memory that answers in any order, and users of the other channels that stall at random.
pub struct Environment<'s> {
    scene: &'s [u8],
    beat_bytes: usize,
    behaviour: Behaviour,
    random: ChaCha8Rng,
    now: u64,
    pending: Vec<Pending>,
    rays: Vec<RayRequest>,
    next: usize,
    /// The offer stays until it is accepted.
    offers: bool,
    pub replies: BTreeMap<u64, Reply>,
}

struct Pending {
    due: u64,
    tag: u32,
    block: [u8; BLOCK_BYTES as usize],
    is_missing: bool,
    beat: usize,
}

impl<'s> Environment<'s> {
    pub fn new(scene: &'s [u8], memory_width: u32, rays: Vec<RayRequest>, behaviour: Behaviour, seed: u64) -> Self {
        Self {
            scene,
            beat_bytes: memory_width as usize / 8,
            behaviour,
            random: ChaCha8Rng::seed_from_u64(seed),
            now: 0,
            pending: Vec::new(),
            rays,
            next: 0,
            offers: false,
            replies: BTreeMap::new(),
        }
    }

    pub fn is_done(&self) -> bool {
        self.replies.len() == self.rays.len()
    }

    pub fn cycles(&self) -> u64 {
        self.now
    }

    /// Runs all engines in lockstep for a cycle.
    pub fn cycle(&mut self, engines: &mut [&mut dyn UnitEngine]) {
        let outputs = engines[0].outputs();
        for (number, engine) in engines.iter_mut().enumerate().skip(1) {
            assert_eq!(engine.outputs(), outputs, "engine {number} in cycle {}", self.now);
        }
        let stalls = self.behaviour.stalls.map(|share| self.random.random_range(0..256) < share);
        self.offers |= !stalls[0] && self.next < self.rays.len();
        let ray = self.offers.then(|| (self.next as u64, self.rays[self.next]));
        let (hit_ready, request_ready) = (!stalls[1], !stalls[2]);
        let due: Vec<usize> = (0..self.pending.len()).filter(|&k| self.pending[k].due <= self.now).collect();
        let chosen = (!stalls[3] && !due.is_empty()).then(|| due[self.random.random_range(0..due.len())]);
        let is_error = self.random.random_range(0..65_536) < self.behaviour.errors;
        let mut beat = Vec::new();
        let response = chosen.map(|k| {
            let Pending { tag, block, is_missing, beat: number, .. } = &self.pending[k];
            beat.extend(&block[number * self.beat_bytes..][..self.beat_bytes]);
            Response { tag: *tag, is_error: is_error || *is_missing, beat: &beat }
        });
        let inputs = UnitInputs { ray, hit_ready, request_ready, response };
        engines.iter_mut().for_each(|engine| engine.cycle(&inputs));

        if let Some(k) = chosen {
            self.pending[k].beat += 1;
            if self.pending[k].beat * self.beat_bytes == BLOCK_BYTES as usize {
                self.pending.swap_remove(k);
            }
        }
        if outputs.ray_ready && ray.is_some() {
            self.next += 1;
            self.offers = false;
        }
        if let (Some((id, reply)), true) = (outputs.hit, hit_ready) {
            assert!(self.replies.insert(id, reply).is_none(), "ray {id} ends twice");
        }
        if let (Some(BlockRequest { address, tag }), true) = (outputs.request, request_ready) {
            assert!(self.pending.iter().all(|pending| pending.tag != tag), "tag {tag} is in use");
            let (least, greatest) = self.behaviour.latency;
            let found = self.scene.block(address);
            self.pending.push(Pending {
                due: self.now + self.random.random_range(least..=greatest),
                tag,
                block: *found.unwrap_or(&[0xff; BLOCK_BYTES as usize]),
                is_missing: found.is_err(),
                beat: 0,
            });
        }
        self.now += 1;
    }
}
