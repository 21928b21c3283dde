//! A scene as the traversal unit reads it from memory.

use crate::bvh::{Bvh4, Node, Reference, Target};
use raypath_ops::{Binary32, Ray};
use raypath_unit::RayRequest;
use raypath_unit::blocks::quantised::BoxError;
use raypath_unit::blocks::{Child, LeafTriangle, Node as NodeBlock, NodeKind};
use thiserror::Error;

/// A scene in memory: the blocks of [`raypath_unit::blocks`] from address 0 on. The nodes come first, the root at 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Blocks {
    bytes: Vec<u8>,
    nodes: NodeKind,
    root: u32,
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
    /// A box has no quantised bounds.
    #[error("the box of triangle {triangle} cannot be quantised: {problem}")]
    Box {
        /// A triangle of the mesh in the box.
        triangle: u32,
        /// The problem.
        problem: BoxError,
    },
}

impl Blocks {
    /// The blocks of a tree, with these nodes.
    ///
    /// # Errors
    /// They take more than 4 GiB, or a box has no quantised bounds.
    pub fn of(bvh: &Bvh4, kind: NodeKind) -> Result<Self, BlocksError> {
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
                        let triangle = |slot| LeafTriangle { triangle: *bvh.triangle(slot), index: bvh.index(slot) };
                        leaves.extend(LeafTriangle::to_bytes(&slots.map(triangle).collect::<Vec<_>>(), kind));
                        Child::Leaf { address, count }
                    }
                };
                // Addresses are multiples of a block and leaves have 1 to 8 triangles, so the word is valid.
                *word = child.word(kind).unwrap_or(0);
            }
            let block = NodeBlock { boxes: node.boxes, children: words };
            match kind {
                NodeKind::Wide4 => nodes.extend(block.to_bytes()),
                NodeKind::Quantised => nodes.extend(block.to_quantised_bytes().map_err(|problem| {
                    let triangle = triangle_below(bvh, node.children[problem.child]);
                    BlocksError::Box { triangle, problem }
                })?),
            }
        }
        nodes.extend(leaves);
        let root = Child::Node { address: 0 }.word(kind).unwrap_or(0);
        Ok(Self { bytes: nodes, nodes: kind, root })
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
        RayRequest {
            origin: ray.origin.into(),
            direction: ray.dir.into(),
            t_min: 0.0,
            t_max: ray.extent.into(),
            any_hit,
            cull_back: !two_sided,
            cull_front: false,
            root: self.root,
        }
    }

    /// The child word of the root, which each ray begins with.
    pub fn root(&self) -> u32 {
        self.root
    }
}

/// The index of a triangle below a child.
fn triangle_below(bvh: &Bvh4, mut child: Reference) -> u32 {
    loop {
        match child.target() {
            Target::Node(index) => child = bvh.nodes()[index as usize].children[0],
            Target::Leaf { first, .. } => return bvh.index(first),
        }
    }
}

/// The children of a node that exist. They come first.
fn children(node: &Node) -> impl Iterator<Item = Reference> + '_ {
    let exists = |child: &usize| node.boxes[*child].x.min.value.0 <= node.boxes[*child].x.max.value.0;
    (0..4).take_while(exists).map(|child| node.children[child])
}
