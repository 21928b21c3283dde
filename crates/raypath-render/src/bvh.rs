//! The tree that rays descend: four boxes a node, as the datapath takes them.

use crate::mesh::{Bounds, Mesh};
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris};
use obvhs::{BvhBuildParams, triangle::Triangle as PeerTriangle};
use raypath_ops::{Aabb, Binary32, Triangle};
use std::time::Duration;
use thiserror::Error;

/// A bounding volume hierarchy of four boxes a node.
///
/// # Boxes of children that do not exist
/// min is +∞ and max −∞. Whatever the ray, the near distance of such a slab is +∞ and the far one −∞ (no NaN: ±∞ less a
/// finite origin is ±∞, and no inverse is 0), so tmin = +∞ exceeds tmax = −∞: a miss in both rule sets. (Boxes of NaN
/// would be hit: a NaN distance drops out of max and min.)
///
/// # How boxes are padded
/// Box tests and triangle tests round differently, so a ray through an edge could hit a triangle and miss the box around
/// it. By `docs/reference/error-bounds.md`, nothing slips between faces because the ray passes through the closed
/// triangle
/// A′B′C′ *as computed*. With R the greatest distance along any axis from the ray's origin to a vertex, and u = 2⁻²⁴:
///
/// - each computed vertex is within γ₄·(|r_kx| + |Sx·r_kz|) ≤ 8.01·u·R of the exact one along kx, and along ky, and not
///   moved along kz. So the same weights that make the ray out of A′, B′, C′ make a point Q of the exact triangle out of
///   A, B, C that is within 8.01·u·R of the exact ray along each axis.
/// - A slab distance is off by at most 3.01·u of itself, which along its axis is at most 3.01·u·R. A box that is larger
///   by that much on each side has computed near distances at most, and computed far distances at least, those at which
///   the exact ray passes Q.
/// - A hit's t is at least the least depth of the vertices but for γ₈, that is along kz less by at most 8.01·u·R; with
///   the 3.01·u·R of the near distance along kz, the box is entered along kz no later than t.
///
/// So boxes padded by 12·u·R on every side, rounded outwards, are hit whenever one of their triangles has the ray in its
/// closed computed triangle. R is the scene's *reach*, which it is built for. Reach 16 (in units of the scene's longest
/// side) pads by 1.1·10⁻⁵ of it. Conditions are those of `docs/reference/error-bounds.md`: components of the direction
/// are 0 or
/// between 2⁻¹²⁶ and 2¹²⁶, nothing overflows.
///
/// Where cancellation costs a triangle's t more than its depth range (a face seen edge-on), t may be less than where the
/// ray enters the box *along kx or ky*. Such a hit can be culled in favour of another whose t lies between; there is
/// always another, so nothing slips through, but which of the two is reported follows the tree.
#[derive(Debug, Clone)]
pub struct Bvh4 {
    nodes: Vec<Node>,
    /// In the order of leaves.
    triangles: Vec<Triangle<Binary32>>,
    /// Of each of `triangles`, its index in the mesh.
    indices: Vec<u32>,
    /// How many references a traversal must be able to keep for later.
    stack: usize,
    reach: f32,
}

/// Four children.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Their boxes, padded; of a child that does not exist, one that is never hit.
    pub boxes: [Aabb<Binary32>; 4],
    /// Who they are; of a child that does not exist, the root, to which no hit leads.
    pub children: [Reference; 4],
}

/// A node or a leaf, in 32 bits: for a leaf bit 31 is set, bits 30 to 28 are the number of its triangles less one, and
/// the others the place of the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Reference(u32);

/// What a [`Reference`] refers to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// The node of this number.
    Node(u32),
    /// Triangles: those at these places, at least 1 and at most 8.
    Leaf {
        /// The place of the first in [`Bvh4::triangle`].
        first: u32,
        /// How many.
        count: u32,
    },
}

/// A mesh of more triangles than a reference can name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("{triangles} triangles, expected at most {}", Bvh4::MOST_TRIANGLES)]
pub struct MeshTooLarge {
    /// How many it has.
    pub triangles: usize,
}

impl Reference {
    /// The root of every tree.
    pub const ROOT: Self = Self(0);
    const LEAF: u32 = 1 << 31;
    const PLACE_BITS: u32 = 28;
    const MOST_IN_LEAF: u32 = 8;

    fn leaf(first: u32, count: u32) -> Self {
        Self(Self::LEAF | (count - 1) << Self::PLACE_BITS | first)
    }

    /// What it refers to.
    #[inline]
    pub fn target(self) -> Target {
        if self.0 & Self::LEAF == 0 {
            return Target::Node(self.0);
        }
        let count = (self.0 >> Self::PLACE_BITS & (Self::MOST_IN_LEAF - 1)) + 1;
        Target::Leaf { first: self.0 & ((1 << Self::PLACE_BITS) - 1), count }
    }
}

impl Bvh4 {
    /// The greatest number of triangles, 2²⁸.
    pub const MOST_TRIANGLES: usize = 1 << Reference::PLACE_BITS;

    /// The tree over a mesh for rays whose origins are, along each axis, at most `reach` from every vertex.
    ///
    /// # Errors
    /// More than [`MOST_TRIANGLES`](Self::MOST_TRIANGLES) triangles.
    pub fn build(mesh: &Mesh, reach: f32) -> Result<Self, MeshTooLarge> {
        let triangles = mesh.triangles().len();
        if triangles > Self::MOST_TRIANGLES {
            return Err(MeshTooLarge { triangles });
        }
        let mut tree = Collapse::new(mesh, reach);
        tree.run(&binary_tree(mesh));
        Ok(tree.bvh)
    }

    /// The nodes; the root is the first.
    #[inline]
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The triangle at a place.
    #[inline]
    pub fn triangle(&self, place: u32) -> &Triangle<Binary32> {
        &self.triangles[place as usize]
    }

    /// Which triangle of the mesh stands at a place.
    #[inline]
    pub fn index(&self, place: u32) -> u32 {
        self.indices[place as usize]
    }

    /// How many triangles it holds: those of the mesh.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// How many references a traversal may have to keep for later.
    pub fn stack_size(&self) -> usize {
        self.stack
    }

    /// The reach it was built for.
    pub fn reach(&self) -> f32 {
        self.reach
    }
}

/// The binary tree that is collapsed: by obvhs, for a triangle test that costs about as much as a box test for four.
pub(crate) fn binary_tree(mesh: &Mesh) -> Bvh2 {
    let parameters =
        BvhBuildParams { max_prims_per_leaf: 4, collapse_traversal_cost: 1.0, ..BvhBuildParams::medium_build() };
    build_bvh2_from_tris(&peer_triangles(mesh), parameters, &mut Duration::default())
}

/// The mesh's triangles as obvhs has them.
pub(crate) fn peer_triangles(mesh: &Mesh) -> Vec<PeerTriangle> {
    let corners = (0..mesh.triangles().len() as u32).map(|index| mesh.corners(index));
    corners.map(|[a, b, c]| PeerTriangle { v0: a.into(), v1: b.into(), v2: c.into() }).collect()
}

/// A binary tree on its way to one of four children a node.
struct Collapse<'m> {
    mesh: &'m Mesh,
    pad: f64,
    bvh: Bvh4,
}

/// Part of a binary tree that becomes a child.
#[derive(Debug, Clone, Copy)]
enum Part {
    /// A node of the binary tree with two children.
    Inner(u32),
    /// A run of its list of triangles.
    Run { first: u32, count: u32 },
}

/// A node that is still to be made.
struct Task {
    node: usize,
    part: Part,
    /// References that wait when a ray gets here.
    waiting: usize,
}

impl<'m> Collapse<'m> {
    fn new(mesh: &'m Mesh, reach: f32) -> Self {
        let pad = 12.0 * f64::from(f32::EPSILON / 2.0) * f64::from(reach);
        let (nodes, triangles, indices) = (Vec::new(), Vec::new(), Vec::new());
        Self { mesh, pad, bvh: Bvh4 { nodes, triangles, indices, stack: 0, reach } }
    }

    fn run(&mut self, tree: &Bvh2) {
        self.bvh.nodes.push(Node::empty());
        let mut tasks = vec![Task { node: 0, part: part(tree, 0), waiting: 0 }];
        while let Some(Task { node, part, waiting }) = tasks.pop() {
            let parts = opened(tree, part);
            let waiting = waiting + parts.len() - 1;
            self.bvh.stack = self.bvh.stack.max(waiting + 1);
            for (child, part) in parts.into_iter().enumerate() {
                let reference = match part {
                    Part::Run { first, count } if count <= Reference::MOST_IN_LEAF => self.leaf(tree, first, count),
                    _ => {
                        let node = self.bvh.nodes.len();
                        self.bvh.nodes.push(Node::empty());
                        tasks.push(Task { node, part, waiting });
                        Reference(node as u32)
                    }
                };
                self.bvh.nodes[node].children[child] = reference;
                self.bvh.nodes[node].boxes[child] = padded(self.bounds(tree, part), self.pad);
            }
        }
    }

    /// Appends a leaf's triangles.
    fn leaf(&mut self, tree: &Bvh2, first: u32, count: u32) -> Reference {
        let place = self.bvh.triangles.len() as u32;
        for &index in run(tree, first, count) {
            let [a, b, c] = self.mesh.corners(index);
            self.bvh.triangles.push(Triangle::new(a, b, c));
            self.bvh.indices.push(index);
        }
        Reference::leaf(place, count)
    }

    fn bounds(&self, tree: &Bvh2, part: Part) -> Bounds {
        match part {
            // obvhs only chooses among coordinates, so its boxes are exact.
            Part::Inner(node) => {
                let aabb = tree.nodes[node as usize].aabb();
                Bounds { min: aabb.min.into(), max: aabb.max.into() }
            }
            Part::Run { first, count } => {
                let corners = run(tree, first, count).iter().flat_map(|&index| self.mesh.corners(index));
                corners.fold(Bounds::EMPTY, Bounds::with)
            }
        }
    }
}

impl Node {
    /// A node without children.
    fn empty() -> Self {
        let never_hit = Aabb::new(Bounds::EMPTY.min, Bounds::EMPTY.max);
        Self { boxes: [never_hit; 4], children: [Reference::ROOT; 4] }
    }
}

fn part(tree: &Bvh2, node: u32) -> Part {
    let data = &tree.nodes[node as usize];
    if data.is_leaf() { Part::Run { first: data.first_index, count: data.prim_count } } else { Part::Inner(node) }
}

fn run(tree: &Bvh2, first: u32, count: u32) -> &[u32] {
    &tree.primitive_indices[first as usize..(first + count) as usize]
}

/// Up to four parts of a part: again and again the one with the greatest surface is opened, for it is hit most often.
fn opened(tree: &Bvh2, part: Part) -> Vec<Part> {
    let mut parts = vec![part];
    while parts.len() < 4 {
        let openable = parts.iter().enumerate().filter_map(|(place, part)| Some((place, surface(tree, *part)?)));
        let Some((place, _)) = openable.max_by(|(_, a), (_, b)| a.total_cmp(b)) else { break };
        let halves = halves(tree, parts.swap_remove(place));
        parts.extend(halves);
    }
    parts
}

/// What an inner part's box has of surface, to compare with others; `None` for what is a leaf.
fn surface(tree: &Bvh2, part: Part) -> Option<f32> {
    match part {
        Part::Inner(node) => Some(tree.nodes[node as usize].aabb().half_area()),
        Part::Run { count, .. } => (count > Reference::MOST_IN_LEAF).then_some(f32::INFINITY),
    }
}

fn halves(tree: &Bvh2, inner: Part) -> [Part; 2] {
    match inner {
        Part::Inner(node) => {
            let first = tree.nodes[node as usize].first_index;
            [part(tree, first), part(tree, first + 1)]
        }
        Part::Run { first, count } => {
            let half = count / 2;
            [Part::Run { first, count: half }, Part::Run { first: first + half, count: count - half }]
        }
    }
}

/// The box with `pad` more on each side, rounded outwards.
fn padded(bounds: Bounds, pad: f64) -> Aabb<Binary32> {
    let below = |bound: f32| {
        let exact = f64::from(bound) - pad;
        let rounded = exact as f32;
        if f64::from(rounded) > exact { rounded.next_down() } else { rounded }
    };
    let min = bounds.min.map(below);
    let max = bounds.max.map(|bound| -below(-bound));
    Aabb::new(min, max)
}
