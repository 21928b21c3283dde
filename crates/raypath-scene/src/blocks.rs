//! A scene as the traversal unit reads it from memory.

use crate::bvh::{Bvh4, Node, Reference, Target, padded};
use crate::mesh::{Bounds, Geometry, TrianglePlace};
use crate::placement::Placement;
use raypath_ops::{Aabb, Binary32, Ray};
use raypath_traversal::blocks::quantised::BoxError;
use raypath_traversal::blocks::{Child, LeafTriangle, Node as NodeBlock, NodeKind};
use raypath_traversal::{LEVELS, Queries, RayRequest, UnitFeatures, ray_flags};
use thiserror::Error;

/// A scene in memory: the blocks of [`raypath_traversal::blocks`] from address 0 on. The nodes come first, the root at
/// 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Blocks {
    bytes: Vec<u8>,
    nodes: NodeKind,
    root: u32,
    features: UnitFeatures,
    /// Around instances, with their margins.
    bounds: Bounds,
}

/// The reason why a scene has no blocks.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum BlocksError {
    /// The scene does not fit into an address space of 32 bits.
    #[error("the scene takes {bytes} bytes, expected at most {}", u32::MAX)]
    TooLarge {
        /// The bytes of the scene.
        bytes: u64,
    },
    /// The unit does not read trees of so many levels.
    #[error("the tree of the scene is {levels} levels deep, expected at most {LEVELS}, which the unit reads")]
    TooDeep {
        /// The levels of nodes and instances.
        levels: u32,
    },
    /// A box has no quantised bounds.
    #[error(transparent)]
    Box(#[from] BoxError),
}

impl Blocks {
    /// The blocks of a tree, with these nodes.
    ///
    /// # Errors
    /// They take more than 4 GiB, the tree has more than 64 levels, or a box has no quantised bounds.
    pub fn of(bvh: &Bvh4, kind: NodeKind) -> Result<Self, BlocksError> {
        check_levels(bvh.levels())?;
        let block_bytes = kind.block_bytes();
        let leaves = bvh.nodes().iter().flat_map(children).filter_map(|child| match child.target() {
            Target::Leaf { count, .. } => Some(u64::from(kind.leaf_blocks(count))),
            Target::Node(_) => None,
        });
        let size = (bvh.nodes().len() as u64 + leaves.sum::<u64>()) * u64::from(block_bytes);
        if size > u64::from(u32::MAX) {
            return Err(BlocksError::TooLarge { bytes: size });
        }
        let (mut nodes, mut leaves) = (Vec::new(), Vec::new());
        let first_leaf = bvh.nodes().len() as u32 * block_bytes;
        for node in bvh.nodes() {
            let mut words = [0; 4];
            for (word, child) in words.iter_mut().zip(children(node)) {
                let child = match child.target() {
                    Target::Node(index) => Child::Node { address: index * block_bytes },
                    Target::Leaf { first, count } => {
                        let address = first_leaf + leaves.len() as u32;
                        let slots = first..first + count;
                        let triangle =
                            |slot| LeafTriangle { triangle: *bvh.triangle(slot), index: bvh.place(slot).primitive };
                        let TrianglePlace { geometry, .. } = bvh.place(first);
                        let triangles: Vec<_> = slots.map(triangle).collect();
                        leaves.extend(LeafTriangle::to_bytes(&triangles, geometry, kind));
                        match bvh.geometries()[geometry as usize] {
                            Geometry { is_opaque, is_boxes: false } => Child::Leaf { address, count, is_opaque },
                            Geometry { is_opaque, is_boxes: true } => Child::Box { address, is_opaque },
                        }
                    }
                };
                // Addresses are multiples of a block and leaves have 1 to 8 triangles, so the word is valid.
                *word = child.word(kind).unwrap_or(0);
            }
            nodes.extend(node_bytes(&NodeBlock { boxes: node.boxes, children: words }, kind)?);
        }
        nodes.extend(leaves);
        let root = Child::Node { address: 0 }.word(kind).unwrap_or(0);
        let queries = match bvh.geometries() {
            [Geometry::OPAQUE] => Queries::None,
            geometries if geometries.iter().any(|geometry| geometry.is_boxes) => Queries::Full,
            _ => Queries::Flags,
        };
        let features = UnitFeatures { queries, ..UnitFeatures::OFF };
        Ok(Self { bytes: nodes, nodes: kind, root, features, bounds: Bounds::EMPTY })
    }

    /// The blocks of instances of an object, each with its bounds in the scene and how much larger its box is.
    ///
    /// # Errors
    /// They take more than 4 GiB, or the tree has more than 64 levels.
    pub fn with_instances(
        object: &Bvh4,
        placed: &[(Placement, Bounds, f64)],
        kind: NodeKind,
    ) -> Result<Self, BlocksError> {
        let blocks = Self::of(object, kind)?;
        let object = (blocks.root, object.levels());
        let placed: Vec<Placed> =
            placed.iter().map(|&(placement, bounds, pad)| Placed { placement, object, bounds, pad }).collect();
        blocks.placed(&placed)
    }

    /// Objects in memory, of which nothing is placed yet.
    pub(crate) fn of_bytes(bytes: Vec<u8>, nodes: NodeKind) -> Self {
        let features = UnitFeatures::OFF;
        Self { bytes, nodes, root: 0, features, bounds: Bounds::EMPTY }
    }

    /// These objects with instances of them, of which there is at least one.
    ///
    /// # Errors
    /// They take more than 4 GiB, or the tree has more than 64 levels.
    pub(crate) fn placed(mut self, placed: &[Placed]) -> Result<Self, BlocksError> {
        let kind = self.nodes;
        // A node for at least two children, so that there are fewer than instances.
        let bytes = self.bytes.len() as u64 + 2 * placed.len() as u64 * u64::from(kind.block_bytes());
        if bytes > u64::from(u32::MAX) {
            return Err(BlocksError::TooLarge { bytes });
        }
        let mut parts: Vec<Part> = Vec::with_capacity(placed.len());
        for (index, Placed { placement, object: (root, levels), bounds, pad }) in (0..).zip(placed) {
            let word = Child::Instance { address: self.bytes.len() as u32 }.word(kind).unwrap_or(0);
            let instance = placement.instance(*root, index);
            if (instance.mask, instance.custom_index, instance.shader_offset, instance.flags) != (u8::MAX, 0, 0, 0) {
                self.features.queries = self.features.queries.max(Queries::Flags);
            }
            self.bytes.extend(instance.to_bytes(kind));
            let centre = bounds.centre();
            parts.push(Part { word, centre, aabb: padded(*bounds, *pad), levels: levels + 1 });
        }
        let top = self.upper(&mut parts)?;
        check_levels(top.levels)?;
        (self.root, self.bounds) = (top.word, bounds_of(&top.aabb));
        self.features.instances = true;
        Ok(self)
    }

    /// Instances are in others, if `are_nested`.
    pub(crate) fn nest_if(&mut self, are_nested: bool) {
        self.features.nested |= are_nested;
    }

    /// The box around its instances, with their margins; empty without instances.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Appends the nodes over parts, of which there is at least one: they are divided along the axis on which their
    /// centres differ the most, twice, into four.
    fn upper(&mut self, parts: &mut [Part]) -> Result<Part, BlocksError> {
        if let [part] = parts {
            return Ok(*part);
        }
        let (left, right) = halves(parts);
        let quarters = [left, right].map(|half| if half.len() > 1 { halves(half) } else { (half, &mut [] as &mut _) });
        let mut children: Vec<Part> = Vec::new();
        for (first, second) in quarters {
            for part in [first, second].into_iter().filter(|part| !part.is_empty()) {
                children.push(self.upper(part)?);
            }
        }
        let (mut boxes, mut words) = ([Aabb::new(Bounds::EMPTY.min, Bounds::EMPTY.max); 4], [0; 4]);
        for (place, child) in children.iter().enumerate() {
            (boxes[place], words[place]) = (child.aabb, child.word);
        }
        let word = Child::Node { address: self.bytes.len() as u32 }.word(self.nodes).unwrap_or(0);
        self.bytes.extend(node_bytes(&NodeBlock { boxes, children: words }, self.nodes)?);
        let all = children.iter().fold(Bounds::EMPTY, |all, child| all.union(bounds_of(&child.aabb)));
        let levels = 1 + children.iter().map(|child| child.levels).max().unwrap_or(0);
        Ok(Part { word, centre: all.centre(), aabb: Aabb::new(all.min, all.max), levels })
    }

    /// What a unit needs beside the default for this scene.
    pub fn features(&self) -> UnitFeatures {
        self.features
    }

    /// The bytes, from address 0 on.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The number of blocks, which is at least 1.
    #[expect(clippy::len_without_is_empty, reason = "a tree has a root")]
    pub fn len(&self) -> usize {
        self.bytes.len() / self.nodes.block_bytes() as usize
    }

    /// The kind of its nodes.
    pub fn nodes(&self) -> NodeKind {
        self.nodes
    }

    /// A ray as the unit takes it, for this scene.
    pub fn request(&self, ray: &Ray<Binary32>, any_hit: bool, two_sided: bool) -> RayRequest {
        let ends = if any_hit { ray_flags::TERMINATE_ON_FIRST_HIT } else { 0 };
        let culls = if two_sided { 0 } else { ray_flags::CULL_BACK_FACING_TRIANGLES };
        RayRequest {
            origin: ray.origin.into(),
            direction: ray.dir.into(),
            t_min: 0.0,
            t_max: ray.extent.into(),
            flags: ends | culls,
            root: self.root,
            ..RayRequest::NONE
        }
    }

    /// The child word of the root, which each ray begins with.
    pub fn root(&self) -> u32 {
        self.root
    }
}

fn node_bytes(node: &NodeBlock, kind: NodeKind) -> Result<Vec<u8>, BoxError> {
    match kind {
        NodeKind::Wide4 => Ok(node.to_bytes().to_vec()),
        NodeKind::Quantised => node.to_quantised_bytes().map(|bytes| bytes.to_vec()),
    }
}

/// An object at a place: the child word of its root and its levels, its bounds in the scene, and how much larger its box
/// is.
pub(crate) struct Placed {
    pub placement: Placement,
    pub object: (u32, u32),
    pub bounds: Bounds,
    pub pad: f64,
}

/// A part of the upper level of a scene.
#[derive(Debug, Clone, Copy)]
struct Part {
    word: u32,
    centre: [f32; 3],
    aabb: Aabb<Binary32>,
    /// The levels of nodes and instances, with those below.
    levels: u32,
}

fn check_levels(levels: u32) -> Result<(), BlocksError> {
    if levels > LEVELS { Err(BlocksError::TooDeep { levels }) } else { Ok(()) }
}

/// Parts on either side along the axis on which their centres differ the most.
fn halves(parts: &mut [Part]) -> (&mut [Part], &mut [Part]) {
    let all = parts.iter().fold(Bounds::EMPTY, |all, part| all.with(part.centre));
    let side = |axis: usize| all.max[axis] - all.min[axis];
    let axis = (0..3).max_by(|&a, &b| side(a).total_cmp(&side(b))).unwrap_or(0);
    let middle = parts.len() / 2;
    parts.select_nth_unstable_by(middle, |a, b| a.centre[axis].total_cmp(&b.centre[axis]));
    parts.split_at_mut(middle)
}

fn bounds_of(aabb: &Aabb<Binary32>) -> Bounds {
    let slabs = [aabb.x, aabb.y, aabb.z];
    Bounds { min: slabs.map(|slab| slab.min.into()), max: slabs.map(|slab| slab.max.into()) }
}

/// The children of a node that exist. They come first.
fn children(node: &Node) -> impl Iterator<Item = Reference> + '_ {
    let exists = |child: &usize| node.boxes[*child].x.min.value.0 <= node.boxes[*child].x.max.value.0;
    (0..4).take_while(exists).map(|child| node.children[child])
}
