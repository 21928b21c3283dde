//! A scene as the traversal unit reads it from memory.

use crate::bvh::{self, Bvh, Reference, Target, padded};
use crate::mesh::{Bounds, Geometry, TrianglePlace};
use crate::placement::Placement;
use raypath_ops::{Aabb, Binary32, Ray};
use raypath_traversal::blocks::quantised::BoxError;
use raypath_traversal::blocks::wide8::{Node8, Node8Error};
use raypath_traversal::blocks::{Child, LeafTriangle, Node, NodeKind};
use raypath_traversal::{LEVELS, Queries, RayRequest, UnitFeatures, ray_flags};
use std::array;
use std::ops::Range;
use thiserror::Error;

/// A scene in memory: the blocks of [`raypath_traversal::blocks`] from address 0 on. The nodes come first, the root at
/// 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Blocks {
    bytes: Vec<u8>,
    nodes: NodeKind,
    root: u32,
    /// The levels of the unit that its tree takes at most.
    levels: u32,
    /// The nodes of the object that it was made of.
    node_count: usize,
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
    /// A node with eight children has none of its kind.
    #[error(transparent)]
    Node(#[from] Node8Error),
}

impl Blocks {
    /// The blocks of a tree, with nodes of this kind, which have as many children.
    ///
    /// # Errors
    /// They take more than 4 GiB, the tree has more than 64 levels, or a box has no quantised bounds.
    pub(crate) fn of<const WIDTH: usize>(bvh: &Bvh<WIDTH>, kind: NodeKind) -> Result<Self, BlocksError> {
        let levels = bvh.levels() * kind.node_levels(WIDTH);
        check_levels(levels)?;
        let block_bytes = kind.block_bytes();
        let first_leaf = bvh.nodes().len() as u64 * u64::from(block_bytes);
        check_size(first_leaf)?;
        let (mut nodes, mut leaves) = (Vec::new(), Vec::new());
        for node in bvh.nodes() {
            let mut word = |(aabb, child): (_, Reference)| {
                let child = match child.target() {
                    Target::Node(index) => Child::Node { address: index * block_bytes },
                    Target::Leaf { first, count } => {
                        let address = first_leaf as u32 + leaves.len() as u32;
                        let slots = first..first + count;
                        let triangle =
                            |slot| LeafTriangle { triangle: *bvh.triangle(slot), index: bvh.place(slot).primitive };
                        let TrianglePlace { geometry, .. } = bvh.place(first);
                        let triangles: Vec<_> = slots.map(triangle).collect();
                        let (blocks, count) = LeafTriangle::to_blocks(&triangles, geometry, kind);
                        leaves.extend(blocks);
                        check_size(first_leaf + leaves.len() as u64)?;
                        match bvh.geometries()[geometry as usize] {
                            Geometry { is_opaque, is_boxes: false } => Child::Leaf { address, count, is_opaque },
                            Geometry { is_opaque, is_boxes: true } => Child::Box { address, is_opaque },
                        }
                    }
                };
                // Addresses are multiples of a block and no leaf has too many triangles, so the word is valid.
                Ok::<_, BlocksError>((aabb, child.word(kind).unwrap_or(0)))
            };
            let words: Vec<_> = children(node).map(&mut word).collect::<Result<_, _>>()?;
            nodes.extend(node_bytes(&words, kind)?);
        }
        nodes.extend(leaves);
        let queries = match bvh.geometries() {
            [Geometry::OPAQUE] => Queries::None,
            geometries if geometries.iter().any(|geometry| geometry.is_boxes) => Queries::Full,
            _ => Queries::Flags,
        };
        let features = UnitFeatures { queries, ..UnitFeatures::OFF };
        Ok(Self { features, ..Self::of_bytes(nodes, kind, bvh.nodes().len(), levels) })
    }

    /// Objects in memory, of which nothing is placed yet. The root of the first is at address 0.
    pub(crate) fn of_bytes(bytes: Vec<u8>, nodes: NodeKind, node_count: usize, levels: u32) -> Self {
        let root = Child::Node { address: 0 }.word(nodes).unwrap_or(0);
        Self { bytes, nodes, root, levels, node_count, features: UnitFeatures::OFF, bounds: Bounds::EMPTY }
    }

    /// This object at places, each with its bounds in the scene and how much larger its box is.
    ///
    /// # Errors
    /// They take more than 4 GiB, or the tree has more than 64 levels.
    pub(crate) fn with_instances(self, placed: &[(Placement, Bounds, f64)]) -> Result<Self, BlocksError> {
        let object = (self.root, self.levels);
        let placed: Vec<Placed> =
            placed.iter().map(|&(placement, bounds, pad)| Placed { placement, object, bounds, pad }).collect();
        self.placed(&placed)
    }

    /// These objects with instances of them, of which there is at least one.
    ///
    /// # Errors
    /// They take more than 4 GiB, or the tree has more than 64 levels.
    pub(crate) fn placed(mut self, placed: &[Placed]) -> Result<Self, BlocksError> {
        // A node has at least two children, so that there are fewer than instances.
        let blocks = 2 * placed.len() as u64;
        check_size(self.bytes.len() as u64 + blocks * u64::from(self.nodes.block_bytes()))?;
        let has_extras = |Placed { placement, .. }: &Placed| {
            let instance = placement.instance(0, 0);
            (instance.mask, instance.custom_index, instance.shader_offset, instance.flags) != (u8::MAX, 0, 0, 0)
        };
        if placed.iter().any(has_extras) {
            self.features.queries = self.features.queries.max(Queries::Flags);
        }
        let part = |(index, Placed { bounds, pad, .. }): (usize, &Placed)| Part {
            index,
            centre: bounds.centre(),
            bounds: bounds_of(&padded(*bounds, *pad)),
        };
        let mut parts: Vec<Part> = placed.iter().enumerate().map(part).collect();
        self.bounds = bounds_of_parts(&parts);
        self.append_instances(placed, &mut parts)?;
        check_levels(self.levels)?;
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

    /// Appends the nodes over these parts, level by level, and then the instances. A node's parts are divided along the
    /// axis on which their centres differ the most, the greatest share first.
    fn append_instances(&mut self, placed: &[Placed], parts: &mut [Part]) -> Result<(), BlocksError> {
        let kind = self.nodes;
        let (first, block_bytes) = (self.bytes.len() as u32, kind.block_bytes());
        let (mut nodes, mut shares, mut depth) = (Vec::new(), Vec::new(), 0);
        // Each with the levels above it.
        nodes.extend((parts.len() > 1).then_some((0..parts.len(), 0)));
        while let Some((node, above)) = nodes.get(shares.len()).cloned() {
            let own = divided(parts, node, kind.children());
            let levels = above + kind.node_levels(own.len());
            nodes.extend(own.iter().filter(|share| share.len() > 1).map(|share| (share.clone(), levels)));
            shares.push(own);
            depth = levels.max(depth);
        }
        let (mut instances, mut children) = (Vec::new(), (1..).map(|node| first + node * block_bytes));
        let mut child = |share: &Range<usize>| {
            let child = if share.len() > 1 {
                Child::Node { address: children.next().unwrap_or(0) }
            } else {
                let address = first + nodes.len() as u32 * block_bytes + instances.len() as u32;
                let index = parts[share.start].index;
                let Placed { placement, object: (root, _), .. } = placed[index];
                instances.extend(placement.instance(root, index as u32).to_bytes(kind));
                Child::Instance { address }
            };
            let Bounds { min, max } = bounds_of_parts(&parts[share.clone()]);
            (Aabb::new(min, max), child.word(kind).unwrap_or(0))
        };
        for own in &shares {
            let words: Vec<_> = own.iter().map(&mut child).collect();
            self.bytes.extend(node_bytes(&words, kind)?);
        }
        self.root = match shares.is_empty() {
            true => child(&(0..1)).1,
            false => Child::Node { address: first }.word(kind).unwrap_or(0),
        };
        self.bytes.extend(instances);
        let below = placed.iter().map(|Placed { object: (_, levels), .. }| levels + 1).max().unwrap_or(0);
        self.levels = below + depth;
        Ok(())
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

    /// The number of nodes of the tree over the triangles of a mesh.
    pub fn node_count(&self) -> usize {
        self.node_count
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

/// The bytes of a node with these children, as many as its kind has at most.
pub(crate) fn node_bytes(children: &[(Aabb<Binary32>, u32)], kind: NodeKind) -> Result<Vec<u8>, BlocksError> {
    let none = (Aabb::new(Bounds::EMPTY.min, Bounds::EMPTY.max), 0);
    let child = |place: usize| children.get(place).copied().unwrap_or(none);
    let four = || Node { boxes: array::from_fn(|k| child(k).0), children: array::from_fn(|k| child(k).1) };
    Ok(match kind {
        NodeKind::Wide4 => four().to_bytes().to_vec(),
        NodeKind::Quantised => four().to_quantised_bytes()?.to_vec(),
        NodeKind::Wide8 => {
            let eight = Node8 { boxes: array::from_fn(|k| child(k).0), children: array::from_fn(|k| child(k).1) };
            eight.to_bytes()?.to_vec()
        }
    })
}

/// An object at a place: the child word of its root and its levels, its bounds in the scene, and how much larger its box
/// is.
pub(crate) struct Placed {
    pub placement: Placement,
    pub object: (u32, u32),
    pub bounds: Bounds,
    pub pad: f64,
}

/// An instance in the upper level of a scene.
#[derive(Debug, Clone, Copy)]
struct Part {
    index: usize,
    centre: [f32; 3],
    /// With its margin.
    bounds: Bounds,
}

fn bounds_of_parts(parts: &[Part]) -> Bounds {
    parts.iter().fold(Bounds::EMPTY, |all, part| all.union(part.bounds))
}

pub(crate) fn check_levels(levels: u32) -> Result<(), BlocksError> {
    if levels > LEVELS { Err(BlocksError::TooDeep { levels }) } else { Ok(()) }
}

pub(crate) fn check_size(bytes: u64) -> Result<(), BlocksError> {
    if bytes > u64::from(u32::MAX) { Err(BlocksError::TooLarge { bytes }) } else { Ok(()) }
}

/// Divides several parts into up to `most` shares: those with the most parts in halves, along the axis on which their
/// centres differ the most.
fn divided(parts: &mut [Part], all: Range<usize>, most: usize) -> Vec<Range<usize>> {
    let mut shares = vec![all];
    while shares.len() < most {
        let several = shares.iter().enumerate().filter(|(_, share)| share.len() > 1);
        let Some((place, share)) = several.max_by_key(|(_, share)| share.len()).map(|(k, share)| (k, share.clone()))
        else {
            break;
        };
        let own = &mut parts[share.clone()];
        let all = own.iter().fold(Bounds::EMPTY, |all, part| all.with(part.centre));
        let side = |axis: usize| all.max[axis] - all.min[axis];
        let axis = (0..3).max_by(|&a, &b| side(a).total_cmp(&side(b))).unwrap_or(0);
        let half = own.len() / 2;
        own.select_nth_unstable_by(half, |a, b| a.centre[axis].total_cmp(&b.centre[axis]));
        let middle = share.start + half;
        shares.splice(place..=place, [share.start..middle, middle..share.end]);
    }
    shares
}

fn bounds_of(aabb: &Aabb<Binary32>) -> Bounds {
    let slabs = [aabb.x, aabb.y, aabb.z];
    Bounds { min: slabs.map(|slab| slab.min.into()), max: slabs.map(|slab| slab.max.into()) }
}

/// The children of a node that exist, with their boxes. They come first.
fn children<const WIDTH: usize>(node: &bvh::Node<WIDTH>) -> impl Iterator<Item = (Aabb<Binary32>, Reference)> + '_ {
    let exists = |(aabb, _): &(Aabb<Binary32>, _)| aabb.x.min.value.0 <= aabb.x.max.value.0;
    node.boxes.iter().copied().zip(node.children).take_while(exists)
}
