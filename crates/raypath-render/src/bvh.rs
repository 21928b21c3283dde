//! The bounding volume hierarchy: a tree with four boxes per node, as the box operation takes them.

use crate::mesh::{Bounds, Mesh};
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris};
use obvhs::{BvhBuildParams, triangle::Triangle as PeerTriangle};
use raypath_ops::{Aabb, Binary32, Triangle};
use std::time::Duration;
use thiserror::Error;

/// A bounding volume hierarchy with four boxes per node.
///
/// # Boxes of missing children
/// min is +∞ and max −∞. For every ray the near distance of such a slab is +∞ and the far one −∞ (no NaN: ±∞ less a
/// finite origin is ±∞, and no inverse is 0), so tmin = +∞ exceeds tmax = −∞: a miss in both rule sets. (Boxes of NaN
/// would be hit, because max and min discard a NaN distance.)
///
/// # Padding of boxes
/// Box tests and triangle tests round differently, so a ray through an edge could hit a triangle and miss the box
/// around it. By `docs/reference/error-bounds.md`, tracing is watertight because the ray passes through the closed
/// triangle A′B′C′ *as computed*. With R the greatest distance along any axis from the ray's origin to a vertex, and
/// u = 2⁻²⁴:
///
/// - each computed vertex is within γ₄·(|r_kx| + |Sx·r_kz|) ≤ 8.01·u·R of the exact one along kx, and along ky, and not
///   moved along kz. So the same weights that make the ray out of A′, B′, C′ make a point Q of the exact triangle
///   out of A, B, C that is within 8.01·u·R of the exact ray along each axis.
/// - A slab distance has a relative error of at most 3.01·u, which along its axis is at most 3.01·u·R. A box that is
///   larger by that much on each side has computed near distances at most, and computed far distances at least, those
///   at which the exact ray passes Q.
/// - The t of a hit is at least the least depth of the vertices up to γ₈, that is less by at most 8.01·u·R along kz.
///   With the 3.01·u·R of the near distance along kz, the box is entered along kz no later than t.
///
/// So boxes padded by 12·u·R on every side, rounded outwards, are hit whenever one of their triangles has the ray in
/// its closed computed triangle. R is the *reach* of the scene. A reach of 16 (in units of the longest side of the
/// mesh) pads by 1.1·10⁻⁵ of that side. The conditions are those of `docs/reference/error-bounds.md`: components of the
/// direction are 0 or between 2⁻¹²⁶ and 2¹²⁶, nothing overflows.
///
/// If cancellation changes t by more than the depth range of a triangle (a face seen edge-on), t may be less than the
/// distance at which the ray enters the box *along kx or ky*. Such a hit can be culled in favour of another whose t
/// lies between. Another hit always exists, so tracing stays watertight, but the structure of the tree decides which of
/// the two is reported.
#[derive(Debug, Clone)]
pub struct Bvh4 {
    nodes: Vec<Node>,
    /// The triangles in the order of leaves. The position in this list is the slot of a triangle.
    triangles: Vec<Triangle<Binary32>>,
    /// The mesh index of each of `triangles`.
    indices: Vec<u32>,
    stack: usize,
    reach: f32,
}

/// An inner node with up to four children.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// The padded boxes of the children; a missing child has a box that no ray hits.
    pub boxes: [Aabb<Binary32>; 4],
    /// The children; a missing child refers to the root.
    pub children: [Reference; 4],
}

/// A reference to a node or a leaf in 32 bits. Bit 31 is set for a leaf; bits 30 to 28 are then the number of its
/// triangles less one, and bits 27 to 0 the slot of the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Reference(u32);

/// The target of a [`Reference`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// The node with this index.
    Node(u32),
    /// A leaf of 1 to 8 triangles in consecutive slots.
    Leaf {
        /// The slot of the first, for [`Bvh4::triangle`].
        first: u32,
        /// The number of triangles.
        count: u32,
    },
}

/// The error of a mesh with more triangles than a reference can address.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("{triangles} triangles, expected at most {}", Bvh4::MAX_TRIANGLES)]
pub struct MeshTooLarge {
    /// The number of triangles of the mesh.
    pub triangles: usize,
}

impl Reference {
    /// The root of every tree.
    pub const ROOT: Self = Self(0);
    const LEAF: u32 = 1 << 31;
    const SLOT_BITS: u32 = 28;
    const MAX_IN_LEAF: u32 = 8;

    fn leaf(first: u32, count: u32) -> Self {
        Self(Self::LEAF | (count - 1) << Self::SLOT_BITS | first)
    }

    /// The target.
    #[inline]
    pub fn target(self) -> Target {
        if self.0 & Self::LEAF == 0 {
            return Target::Node(self.0);
        }
        let count = (self.0 >> Self::SLOT_BITS & (Self::MAX_IN_LEAF - 1)) + 1;
        Target::Leaf { first: self.0 & ((1 << Self::SLOT_BITS) - 1), count }
    }
}

impl Bvh4 {
    /// The maximum number of triangles, 2²⁸.
    pub const MAX_TRIANGLES: usize = 1 << Reference::SLOT_BITS;

    /// Builds the tree of a mesh for ray origins that are, along each axis, at most `reach` from every vertex.
    ///
    /// # Errors
    /// More than [`MAX_TRIANGLES`](Self::MAX_TRIANGLES) triangles.
    pub fn build(mesh: &Mesh, reach: f32) -> Result<Self, MeshTooLarge> {
        let triangles = mesh.triangles().len();
        if triangles > Self::MAX_TRIANGLES {
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

    /// The triangle in a slot.
    #[inline]
    pub fn triangle(&self, slot: u32) -> &Triangle<Binary32> {
        &self.triangles[slot as usize]
    }

    /// The mesh index of the triangle in a slot.
    #[inline]
    pub fn index(&self, slot: u32) -> u32 {
        self.indices[slot as usize]
    }

    /// The number of stack entries that a traversal needs at most.
    pub fn stack_size(&self) -> usize {
        self.stack
    }

    /// The reach for which the tree was built.
    pub fn reach(&self) -> f32 {
        self.reach
    }
}

/// The binary tree before its collapse, built by obvhs with equal costs for a triangle test and a test of four boxes.
pub(crate) fn binary_tree(mesh: &Mesh) -> Bvh2 {
    let parameters =
        BvhBuildParams { max_prims_per_leaf: 4, collapse_traversal_cost: 1.0, ..BvhBuildParams::medium_build() };
    build_bvh2_from_tris(&peer_triangles(mesh), parameters, &mut Duration::default())
}

pub(crate) fn peer_triangles(mesh: &Mesh) -> Vec<PeerTriangle> {
    let corners = (0..mesh.triangles().len() as u32).map(|index| mesh.corners(index));
    corners.map(|[a, b, c]| PeerTriangle { v0: a.into(), v1: b.into(), v2: c.into() }).collect()
}

/// The conversion of a binary tree to one with four children per node.
struct Collapse<'m> {
    mesh: &'m Mesh,
    pad: f64,
    bvh: Bvh4,
}

/// A part of the binary tree that becomes a child of a node.
#[derive(Debug, Clone, Copy)]
enum Subtree {
    /// An inner node of the binary tree.
    Inner(u32),
    /// A range of its list of triangles.
    Range { first: u32, count: u32 },
}

struct Task {
    node: usize,
    part: Subtree,
    /// The stack entries that may be in use when a ray reaches the node.
    stacked: usize,
}

impl<'m> Collapse<'m> {
    fn new(mesh: &'m Mesh, reach: f32) -> Self {
        let pad = 12.0 * f64::from(f32::EPSILON / 2.0) * f64::from(reach);
        let (nodes, triangles, indices) = (Vec::new(), Vec::new(), Vec::new());
        Self { mesh, pad, bvh: Bvh4 { nodes, triangles, indices, stack: 0, reach } }
    }

    fn run(&mut self, tree: &Bvh2) {
        self.bvh.nodes.push(Node::empty());
        let mut tasks = vec![Task { node: 0, part: part(tree, 0), stacked: 0 }];
        while let Some(Task { node, part, stacked }) = tasks.pop() {
            let parts = split(tree, part);
            let stacked = stacked + parts.len() - 1;
            self.bvh.stack = self.bvh.stack.max(stacked + 1);
            for (child, part) in parts.into_iter().enumerate() {
                let reference = match part {
                    Subtree::Range { first, count } if count <= Reference::MAX_IN_LEAF => self.leaf(tree, first, count),
                    _ => {
                        let node = self.bvh.nodes.len();
                        self.bvh.nodes.push(Node::empty());
                        tasks.push(Task { node, part, stacked });
                        Reference(node as u32)
                    }
                };
                self.bvh.nodes[node].children[child] = reference;
                self.bvh.nodes[node].boxes[child] = padded(self.bounds(tree, part), self.pad);
            }
        }
    }

    fn leaf(&mut self, tree: &Bvh2, first: u32, count: u32) -> Reference {
        let slot = self.bvh.triangles.len() as u32;
        for &index in range(tree, first, count) {
            let [a, b, c] = self.mesh.corners(index);
            self.bvh.triangles.push(Triangle::new(a, b, c));
            self.bvh.indices.push(index);
        }
        Reference::leaf(slot, count)
    }

    fn bounds(&self, tree: &Bvh2, part: Subtree) -> Bounds {
        match part {
            // obvhs selects coordinates and does not compute them, so its boxes are exact.
            Subtree::Inner(node) => {
                let aabb = tree.nodes[node as usize].aabb();
                Bounds { min: aabb.min.into(), max: aabb.max.into() }
            }
            Subtree::Range { first, count } => {
                let corners = range(tree, first, count).iter().flat_map(|&index| self.mesh.corners(index));
                corners.fold(Bounds::EMPTY, Bounds::with)
            }
        }
    }
}

impl Node {
    fn empty() -> Self {
        let never_hit = Aabb::new(Bounds::EMPTY.min, Bounds::EMPTY.max);
        Self { boxes: [never_hit; 4], children: [Reference::ROOT; 4] }
    }
}

fn part(tree: &Bvh2, node: u32) -> Subtree {
    let data = &tree.nodes[node as usize];
    if data.is_leaf() {
        Subtree::Range { first: data.first_index, count: data.prim_count }
    } else {
        Subtree::Inner(node)
    }
}

fn range(tree: &Bvh2, first: u32, count: u32) -> &[u32] {
    &tree.primitive_indices[first as usize..(first + count) as usize]
}

/// Splits a part into up to four, by repeatedly splitting the one with the greatest surface, which rays hit most often.
fn split(tree: &Bvh2, part: Subtree) -> Vec<Subtree> {
    let mut parts = vec![part];
    while parts.len() < 4 {
        let divisible = parts.iter().enumerate().filter_map(|(index, part)| Some((index, surface(tree, *part)?)));
        let Some((index, _)) = divisible.max_by(|(_, a), (_, b)| a.total_cmp(b)) else { break };
        let halves = halves(tree, parts.swap_remove(index));
        parts.extend(halves);
    }
    parts
}

/// The surface of a divisible part, for comparison; `None` for a leaf.
fn surface(tree: &Bvh2, part: Subtree) -> Option<f32> {
    match part {
        Subtree::Inner(node) => Some(tree.nodes[node as usize].aabb().half_area()),
        Subtree::Range { count, .. } => (count > Reference::MAX_IN_LEAF).then_some(f32::INFINITY),
    }
}

fn halves(tree: &Bvh2, inner: Subtree) -> [Subtree; 2] {
    match inner {
        Subtree::Inner(node) => {
            let first = tree.nodes[node as usize].first_index;
            [part(tree, first), part(tree, first + 1)]
        }
        Subtree::Range { first, count } => {
            let half = count / 2;
            [Subtree::Range { first, count: half }, Subtree::Range { first: first + half, count: count - half }]
        }
    }
}

/// The box, enlarged by `pad` on each side and rounded outwards.
pub(crate) fn padded(bounds: Bounds, pad: f64) -> Aabb<Binary32> {
    let below = |bound: f32| {
        let exact = f64::from(bound) - pad;
        let rounded = exact as f32;
        if f64::from(rounded) > exact { rounded.next_down() } else { rounded }
    };
    let min = bounds.min.map(below);
    let max = bounds.max.map(|bound| -below(-bound));
    Aabb::new(min, max)
}
