//! A scene as the traversal unit reads it from memory.

use crate::bvh::{Bvh4, Node, Reference, Target};
use raypath_ops::{Binary32, Ray};
use raypath_unit::RayRequest;
use raypath_unit::blocks::{BLOCK_BYTES, Child, LeafTriangle, Node as NodeBlock, leaf_blocks};
use thiserror::Error;

/// A scene in memory: the blocks of [`raypath_unit::blocks`] from address 0 on. The nodes come first, the root at 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Blocks {
    bytes: Vec<u8>,
    root: u32,
}

/// The error of a scene that does not fit into an address space of 32 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("the scene takes {bytes} bytes, expected at most {}", u32::MAX)]
pub struct SceneTooLarge {
    /// The bytes of the scene.
    pub bytes: u64,
}

impl Blocks {
    /// The blocks of a tree.
    ///
    /// # Errors
    /// They take more than 4 GiB.
    pub fn of(bvh: &Bvh4) -> Result<Self, SceneTooLarge> {
        let leaves = bvh.nodes().iter().flat_map(children).filter_map(|child| match child.target() {
            Target::Leaf { count, .. } => Some(u64::from(leaf_blocks(count))),
            Target::Node(_) => None,
        });
        let size = (bvh.nodes().len() as u64 + leaves.sum::<u64>()) * u64::from(BLOCK_BYTES);
        if size > u64::from(u32::MAX) {
            return Err(SceneTooLarge { bytes: size });
        }
        let (mut nodes, mut leaves) = (Vec::new(), Vec::new());
        let first_leaf = bvh.nodes().len() as u32 * BLOCK_BYTES;
        for node in bvh.nodes() {
            let mut words = [0; 4];
            for (word, child) in words.iter_mut().zip(children(node)) {
                let child = match child.target() {
                    Target::Node(index) => Child::Node { address: index * BLOCK_BYTES },
                    Target::Leaf { first, count } => {
                        let address = first_leaf + leaves.len() as u32;
                        let slots = first..first + count;
                        let triangle = |slot| LeafTriangle { triangle: *bvh.triangle(slot), index: bvh.index(slot) };
                        leaves.extend(LeafTriangle::to_bytes(&slots.map(triangle).collect::<Vec<_>>()));
                        Child::Leaf { address, count }
                    }
                };
                // Addresses are multiples of a block and leaves have 1 to 8 triangles, so the word is valid.
                *word = child.word().unwrap_or(0);
            }
            nodes.extend(NodeBlock { boxes: node.boxes, children: words }.to_bytes());
        }
        nodes.extend(leaves);
        let root = Child::Node { address: 0 }.word().unwrap_or(0);
        Ok(Self { bytes: nodes, root })
    }

    /// The bytes, from address 0 on.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The number of blocks, which is at least 1.
    #[expect(clippy::len_without_is_empty, reason = "a tree has a root")]
    pub fn len(&self) -> usize {
        self.bytes.len() / BLOCK_BYTES as usize
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

/// The children of a node that exist. They come first.
fn children(node: &Node) -> impl Iterator<Item = Reference> + '_ {
    let exists = |child: &usize| node.boxes[*child].x.min.value.0 <= node.boxes[*child].x.max.value.0;
    (0..4).take_while(exists).map(|child| node.children[child])
}
