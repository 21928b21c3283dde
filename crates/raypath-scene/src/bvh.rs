//! The bounding volume hierarchy: a tree with four boxes per node, as the box operation takes them, or eight.

use crate::mesh::{Bounds, Geometry, Mesh, TrianglePlace};
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris};
use obvhs::{BvhBuildParams, triangle::Triangle as PeerTriangle};
use raypath_ops::{Aabb, Binary32, Triangle};
use raypath_traversal::blocks::NodeKind;
use std::collections::HashMap;
use std::time::Duration;
use thiserror::Error;

/// A bounding volume hierarchy with four boxes per node.
pub type Bvh4 = Bvh<4>;

/// A bounding volume hierarchy with `WIDTH` boxes per node: 4, or 8.
///
/// # Boxes of missing children
/// min is +∞ and max −∞. For every ray the near distance of such a slab is +∞ and the far one −∞ (no NaN: ±∞ less a
/// finite origin is ±∞, and no inverse is 0), so tmin = +∞ exceeds tmax = −∞: a miss in both rule sets. (Boxes of NaN
/// would be hit, because max and min discard a NaN distance.)
///
/// # Boxes of children
/// They are the exact bounds of what is below. Box tests are [conservative](raypath_ops::RayBox::is_conservative), so no
/// ray that touches a triangle misses a box around it.
///
/// If cancellation changes t by more than the depth range of a triangle (a face seen edge-on), t may be less than the
/// distance at which the ray enters the box *along kx or ky*. Such a hit can be culled in favour of another whose t
/// lies between. Another hit always exists, so tracing stays watertight, but the structure of the tree decides which of
/// the two is reported.
#[derive(Debug, Clone)]
pub struct Bvh<const WIDTH: usize> {
    nodes: Vec<Node<WIDTH>>,
    /// The triangles in the order of leaves. The position in this list is the slot of a triangle.
    triangles: Vec<Triangle<Binary32>>,
    /// The mesh index of each of `triangles`, and its place among geometries.
    indices: Vec<u32>,
    places: Vec<TrianglePlace>,
    geometries: Vec<Geometry>,
    stack: usize,
    levels: u32,
}

/// An inner node with up to `WIDTH` children.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node<const WIDTH: usize = 4> {
    /// The boxes of the children; a missing child has a box that no ray hits.
    pub boxes: [Aabb<Binary32>; WIDTH],
    /// The children; a missing child refers to the root.
    pub children: [Reference; WIDTH],
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
    /// A leaf of 1 to 4 triangles, or 1 to 3 with eight boxes per node, in consecutive slots.
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
    const COUNTS: u32 = 8;

    fn leaf(first: u32, count: u32) -> Self {
        Self(Self::LEAF | (count - 1) << Self::SLOT_BITS | first)
    }

    /// The target.
    #[inline]
    pub fn target(self) -> Target {
        if self.0 & Self::LEAF == 0 {
            return Target::Node(self.0);
        }
        let count = (self.0 >> Self::SLOT_BITS & (Self::COUNTS - 1)) + 1;
        Target::Leaf { first: self.0 & ((1 << Self::SLOT_BITS) - 1), count }
    }
}

impl<const WIDTH: usize> Bvh<WIDTH> {
    /// The maximum number of triangles, 2²⁸.
    pub const MAX_TRIANGLES: usize = 1 << Reference::SLOT_BITS;

    /// The maximum number of levels of nodes. The unit reads 64 levels: those of the object, one of an instance, and at
    /// most 13 above the instances that fit into 4 GiB. A node with eight boxes may take three levels.
    pub const MAX_LEVELS: u32 = if WIDTH > 4 { 16 } else { 48 };

    /// The most triangles in a leaf: those of every kind of nodes with so many boxes.
    const MAX_IN_LEAF: u32 = (if WIDTH > 4 { NodeKind::Wide8 } else { NodeKind::Quantised }).max_leaf();

    /// Builds the tree of a mesh, without its [degenerate](Mesh::is_degenerate) triangles, which are never hit.
    ///
    /// # Errors
    /// More than [`MAX_TRIANGLES`](Self::MAX_TRIANGLES) triangles.
    pub fn build(mesh: &Mesh) -> Result<Self, MeshTooLarge> {
        let triangles = mesh.triangles().len();
        if triangles > Self::MAX_TRIANGLES {
            Err(MeshTooLarge { triangles })
        } else {
            Ok(Self::within(mesh, Self::MAX_LEVELS))
        }
    }

    /// The tree of a mesh with at most `levels` levels, which must be enough for a balanced tree.
    pub(crate) fn within(mesh: &Mesh, levels: u32) -> Self {
        let groups = Groups::of(mesh, Self::MAX_IN_LEAF);
        if groups.first.is_empty() {
            return Self { nodes: vec![Node::empty()], levels: 1, ..Self::without_nodes(mesh) };
        }
        let tree = binary_tree(mesh, &groups.first, Self::MAX_IN_LEAF);
        let mut collapse = Collapse::new(mesh, &groups, &tree, levels);
        collapse.run();
        collapse.bvh
    }

    fn without_nodes(mesh: &Mesh) -> Self {
        Self {
            nodes: Vec::new(),
            triangles: Vec::new(),
            indices: Vec::new(),
            places: Vec::new(),
            geometries: mesh.geometries().to_vec(),
            stack: 0,
            levels: 0,
        }
    }

    /// The nodes; the root is the first.
    #[inline]
    pub fn nodes(&self) -> &[Node<WIDTH>] {
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

    /// The place among geometries of the triangle in a slot. All triangles of a leaf are of one geometry.
    #[inline]
    pub fn place(&self, slot: u32) -> TrianglePlace {
        self.places[slot as usize]
    }

    /// The geometries.
    pub fn geometries(&self) -> &[Geometry] {
        &self.geometries
    }

    /// The number of stack entries that a traversal needs at most.
    pub fn stack_size(&self) -> usize {
        self.stack
    }

    /// The number of levels of nodes, from 1 to [`MAX_LEVELS`](Self::MAX_LEVELS).
    pub fn levels(&self) -> u32 {
        self.levels
    }
}

/// The binary tree of these triangles before its collapse, built by obvhs with equal costs for a triangle test and a
/// test of four boxes.
pub fn binary_tree(mesh: &Mesh, triangles: &[u32], max_in_leaf: u32) -> Bvh2 {
    let parameters = BvhBuildParams {
        max_prims_per_leaf: max_in_leaf,
        collapse_traversal_cost: 1.0,
        ..BvhBuildParams::medium_build()
    };
    build_bvh2_from_tris(&peer_triangles(mesh, triangles), parameters, &mut Duration::default())
}

/// The corners of these triangles, as obvhs has them.
pub fn peer_triangles(mesh: &Mesh, triangles: &[u32]) -> Vec<PeerTriangle> {
    let corners = triangles.iter().map(|&index| mesh.corners(index));
    corners.map(|[a, b, c]| PeerTriangle { v0: a.into(), v1: b.into(), v2: c.into() }).collect()
}

/// The triangles of a mesh that are not degenerate. Those that have one box, if they are more than a leaf holds, are a
/// group, because obvhs takes a time that grows with the square of their number. Every other triangle is a group of its
/// own.
struct Groups {
    /// The first triangle of each group.
    first: Vec<u32>,
    /// The triangles of each group of several, by its first.
    several: HashMap<u32, Vec<u32>>,
}

impl Groups {
    fn of(mesh: &Mesh, max_in_leaf: u32) -> Self {
        let triangles = (0..mesh.triangles().len() as u32).filter(|&index| !mesh.is_degenerate(index));
        let place = |index: u32| {
            let Bounds { min, max } = mesh.corners(index).into_iter().fold(Bounds::EMPTY, Bounds::with);
            [min, max].map(|corner| corner.map(f32::to_bits))
        };
        let mut counts: HashMap<_, u32> = HashMap::new();
        triangles.clone().for_each(|index| *counts.entry(place(index)).or_default() += 1);
        counts.retain(|_, count| *count > max_in_leaf);
        let (mut first, mut firsts, mut several) = (Vec::new(), HashMap::new(), HashMap::new());
        for index in triangles {
            let place = place(index);
            if !counts.contains_key(&place) {
                first.push(index);
                continue;
            }
            let own = *firsts.entry(place).or_insert(index);
            first.extend((own == index).then_some(index));
            several.entry(own).or_insert_with(Vec::new).push(index);
        }
        Self { first, several }
    }

    /// The triangles of the group with this number.
    fn triangles(&self, number: u32) -> &[u32] {
        let first = &self.first[number as usize];
        self.several.get(first).map_or(std::slice::from_ref(first), Vec::as_slice)
    }
}

/// The conversion of a binary tree to one with `WIDTH` children per node.
///
/// Triangles that nest make binary trees as deep as a list, because every division of them looks alike. So the
/// binary tree is followed only where the levels that are left suffice for a balanced tree of the triangles of each
/// child. Elsewhere the triangles are divided by their position in the list.
struct Collapse<'m, const WIDTH: usize> {
    mesh: &'m Mesh,
    tree: &'m Bvh2,
    /// The number of triangles below each node of the binary tree.
    counts: Vec<u32>,
    /// The triangles of the leaves of the binary tree, then those of its parts that are divided by position.
    order: Vec<u32>,
    /// The place of the triangles of each leaf of the binary tree in that list.
    firsts: Vec<u32>,
    max_levels: u32,
    bvh: Bvh<WIDTH>,
}

/// A part of the binary tree that becomes a child of a node.
#[derive(Debug, Clone, Copy)]
enum Subtree {
    /// An inner node of the binary tree.
    Inner(u32),
    /// A range of the list of triangles.
    Range { first: u32, count: u32 },
}

struct Task {
    node: usize,
    part: Subtree,
    /// The number of nodes above.
    level: u32,
    /// The stack entries that may be in use when a ray reaches the node.
    stacked: usize,
}

impl<'m, const WIDTH: usize> Collapse<'m, WIDTH> {
    fn new(mesh: &'m Mesh, groups: &Groups, tree: &'m Bvh2, max_levels: u32) -> Self {
        let bvh = Bvh::without_nodes(mesh);
        let (mut counts, mut firsts, mut order) = (vec![0; tree.nodes.len()], vec![0; tree.nodes.len()], Vec::new());
        for &node in nodes_below(tree, 0).iter().rev() {
            let data = &tree.nodes[node as usize];
            let (node, first) = (node as usize, data.first_index as usize);
            if data.is_leaf() {
                firsts[node] = order.len() as u32;
                let groups_here = &tree.primitive_indices[first..first + data.prim_count as usize];
                order.extend(groups_here.iter().flat_map(|&group| groups.triangles(group)));
                order[firsts[node] as usize..].sort_by_key(|&index| mesh.place(index).geometry);
                counts[node] = order.len() as u32 - firsts[node];
            } else {
                counts[node] = counts[first] + counts[first + 1];
            }
        }
        Self { mesh, tree, counts, order, firsts, max_levels, bvh }
    }

    fn run(&mut self) {
        self.bvh.nodes.push(Node::empty());
        let mut tasks = vec![Task { node: 0, part: self.part(0), level: 0, stacked: 0 }];
        while let Some(Task { node, part, level, stacked }) = tasks.pop() {
            let mut parts = self.split(part);
            let left = self.max_levels - level - 1;
            if parts.iter().any(|part| self.least_levels(*part) > left) {
                let listed = self.listed(part);
                parts = self.split(listed);
            }
            let stacked = stacked + parts.len() - 1;
            self.bvh.stack = self.bvh.stack.max(stacked + 1);
            self.bvh.levels = self.bvh.levels.max(level + 1);
            for (child, part) in parts.into_iter().enumerate() {
                let reference = match part {
                    Subtree::Range { first, count } if self.is_leaf(first, count) => self.leaf(first, count),
                    _ => {
                        let node = self.bvh.nodes.len();
                        self.bvh.nodes.push(Node::empty());
                        tasks.push(Task { node, part, level: level + 1, stacked });
                        Reference(node as u32)
                    }
                };
                self.bvh.nodes[node].children[child] = reference;
                self.bvh.nodes[node].boxes[child] = aabb_of(self.bounds(part));
            }
        }
    }

    /// Whether a range, which is sorted by geometry, becomes a leaf. A procedural box is alone in its leaf.
    fn is_leaf(&self, first: u32, count: u32) -> bool {
        let geometry = |place: u32| self.mesh.place(self.order[place as usize]).geometry;
        let (of_first, of_last) = (geometry(first), geometry(first + count - 1));
        let is_boxes = self.bvh.geometries.get(of_first as usize).is_some_and(|geometry| geometry.is_boxes);
        count <= if is_boxes { 1 } else { Bvh::<WIDTH>::MAX_IN_LEAF } && of_first == of_last
    }

    fn leaf(&mut self, first: u32, count: u32) -> Reference {
        let slot = self.bvh.triangles.len() as u32;
        for &index in &self.order[first as usize..(first + count) as usize] {
            let [a, b, c] = self.mesh.corners(index);
            self.bvh.triangles.push(Triangle::new(a, b, c));
            self.bvh.indices.push(index);
            self.bvh.places.push(self.mesh.place(index));
        }
        Reference::leaf(slot, count)
    }

    fn bounds(&self, part: Subtree) -> Bounds {
        match part {
            // obvhs selects coordinates and does not compute them, so its boxes are exact.
            Subtree::Inner(node) => {
                let aabb = self.tree.nodes[node as usize].aabb();
                Bounds { min: aabb.min.into(), max: aabb.max.into() }
            }
            Subtree::Range { first, count } => {
                let range = &self.order[first as usize..(first + count) as usize];
                range.iter().flat_map(|&index| self.mesh.corners(index)).fold(Bounds::EMPTY, Bounds::with)
            }
        }
    }

    fn part(&self, node: u32) -> Subtree {
        let data = &self.tree.nodes[node as usize];
        if data.is_leaf() {
            Subtree::Range { first: self.firsts[node as usize], count: self.counts[node as usize] }
        } else {
            Subtree::Inner(node)
        }
    }

    /// The triangles of a part as a range.
    fn listed(&mut self, part: Subtree) -> Subtree {
        let Subtree::Inner(node) = part else { return part };
        let first = self.order.len() as u32;
        for node in nodes_below(self.tree, node) {
            if let Subtree::Range { first, count } = self.part(node) {
                self.order.extend_from_within(first as usize..(first + count) as usize);
            }
        }
        let mesh = self.mesh;
        self.order[first as usize..].sort_by_key(|&index| mesh.place(index).geometry);
        Subtree::Range { first, count: self.counts[node as usize] }
    }

    /// The levels of nodes that a part needs at least: those of a balanced tree, and of an inner node one. Several
    /// geometries need leaves of one triangle at most.
    fn least_levels(&self, part: Subtree) -> u32 {
        let full = if self.bvh.geometries == [Geometry::OPAQUE] { Bvh::<WIDTH>::MAX_IN_LEAF } else { 1 };
        match part {
            Subtree::Inner(node) => balanced_levels(self.counts[node as usize], full, WIDTH as u32).max(1),
            Subtree::Range { count, .. } => balanced_levels(count, full, WIDTH as u32),
        }
    }

    /// Splits a part into up to `WIDTH`, by repeatedly splitting the greatest.
    fn split(&self, part: Subtree) -> Vec<Subtree> {
        let mut parts = vec![part];
        while parts.len() < WIDTH {
            let divisible = parts.iter().enumerate().filter_map(|(index, part)| Some((index, self.size(*part)?)));
            let greatest = divisible.max_by(|(_, a), (_, b)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
            let Some((index, _)) = greatest else { break };
            let halves = self.halves(parts.swap_remove(index));
            parts.extend(halves);
        }
        parts
    }

    /// The size of a divisible part, for comparison: the triangles of a range, then the surface of a node, because rays
    /// hit the greatest most often. `None` for a leaf.
    fn size(&self, part: Subtree) -> Option<(u32, f32)> {
        match part {
            Subtree::Inner(node) => Some((0, self.tree.nodes[node as usize].aabb().half_area())),
            Subtree::Range { first, count } => (!self.is_leaf(first, count)).then_some((count, 0.0)),
        }
    }

    fn halves(&self, inner: Subtree) -> [Subtree; 2] {
        match inner {
            Subtree::Inner(node) => {
                let first = self.tree.nodes[node as usize].first_index;
                [self.part(first), self.part(first + 1)]
            }
            Subtree::Range { first, count } => {
                let half = count / 2;
                [Subtree::Range { first, count: half }, Subtree::Range { first: first + half, count: count - half }]
            }
        }
    }
}

/// The nodes of a binary tree from one downwards, each after its parent.
fn nodes_below(tree: &Bvh2, node: u32) -> Vec<u32> {
    let mut nodes = vec![node];
    let mut next = 0;
    while let Some(&node) = nodes.get(next) {
        let data = &tree.nodes[node as usize];
        if !data.is_leaf() {
            nodes.extend([data.first_index, data.first_index + 1]);
        }
        next += 1;
    }
    nodes
}

/// The levels of nodes above the leaves of a balanced tree of this many triangles, of which a leaf has at most `full`.
fn balanced_levels(triangles: u32, full: u32, width: u32) -> u32 {
    if triangles <= full { 0 } else { 1 + balanced_levels(triangles.div_ceil(width), full, width) }
}

impl<const WIDTH: usize> Node<WIDTH> {
    fn empty() -> Self {
        Self { boxes: [aabb_of(Bounds::EMPTY); WIDTH], children: [Reference::ROOT; WIDTH] }
    }
}

fn aabb_of(bounds: Bounds) -> Aabb<Binary32> {
    Aabb::new(bounds.min, bounds.max)
}

/// The box, enlarged by `pad` on each side and rounded outwards.
pub fn padded(bounds: Bounds, pad: f64) -> Aabb<Binary32> {
    let below = |bound: f32| {
        let exact = f64::from(bound) - pad;
        let rounded = exact as f32;
        if f64::from(rounded) > exact { rounded.next_down() } else { rounded }
    };
    let min = bounds.min.map(below);
    let max = bounds.max.map(|bound| -below(-bound));
    Aabb::new(min, max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocks::{Blocks, BlocksError};

    /// A deeper tree than those of [`Bvh4::build`], as the binary tree of nested triangles is, has no blocks.
    #[test]
    fn a_tree_that_is_too_deep_for_the_unit_is_refused() {
        // Triangles of growing size at one corner.
        let corners = (0..1000).flat_map(|n| [[0.0, 0.0, 1.0], [1.0 + n as f32, 0.0, 1.0], [0.0, 1.0 + n as f32, 1.0]]);
        let triangles = (0..1000).map(|n| [3 * n, 3 * n + 1, 3 * n + 2]).collect();
        let mesh = Mesh::new(corners.collect(), triangles).expect("a mesh");
        let deep = Bvh4::within(&mesh, u32::MAX);
        let levels = deep.levels();
        assert!(levels > 64, "{levels} levels");
        assert_eq!(Blocks::of(&deep, NodeKind::Wide4), Err(BlocksError::TooDeep { levels }));
        for max in [7, 20, Bvh4::MAX_LEVELS] {
            let tree = Bvh4::within(&mesh, max);
            assert!(tree.levels() <= max, "{} levels, expected at most {max}", tree.levels());
            assert!(Blocks::of(&tree, NodeKind::Wide4).is_ok());
        }
    }
}
