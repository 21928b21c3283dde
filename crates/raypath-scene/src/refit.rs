//! New vertices for a scene in memory whose tree stays.

use crate::blocks::{BlocksError, node_bytes};
use crate::mesh::{Bounds, Mesh};
use raypath_ops::{Aabb, Triangle};
use raypath_traversal::LEVELS;
use raypath_traversal::blocks::{Child, InvalidChild, LeafTriangle, NodeKind, children};
use std::collections::HashSet;
use thiserror::Error;

/// The reason why a scene cannot have the vertices of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum RefitError {
    /// A child word.
    #[error(transparent)]
    Child(#[from] InvalidChild),
    /// A block that is not there.
    #[error("a block at address {address:#x}, expected one of the {bytes} bytes of the scene")]
    Address {
        /// Its address.
        address: u32,
        /// The bytes of the scene.
        bytes: usize,
    },
    /// A tree that ends nowhere.
    #[error("more than {LEVELS} levels of nodes, expected at most so many")]
    TooDeep,
    /// A block that two parts of the tree have.
    #[error("the block at address {0:#x} comes twice in the tree, expected once")]
    Repeated(u32),
    /// A triangle that the mesh does not have.
    #[error("triangle {index} in the scene, expected less than {triangles}, the number of triangles of the mesh")]
    Triangle {
        /// Its index.
        index: u32,
        /// The number of triangles of the mesh.
        triangles: usize,
    },
    /// A triangle of the mesh that the scene does not have.
    #[error("triangle {0} of the mesh is not in the scene, expected all that are not degenerate")]
    Missing(u32),
    /// Blocks that are not in the tree.
    #[error(
        "{blocks} blocks in the scene, {found} of them in its tree, expected all: a scene of this mesh, without instances"
    )]
    Others {
        /// The blocks of the scene.
        blocks: usize,
        /// Those of its tree.
        found: usize,
    },
    /// A vertex that two triangles of a block shared.
    #[error("triangle {0} of the mesh has a vertex apart that it shares with another in the scene, expected the same")]
    Divided(u32),
    /// What is not made from a mesh.
    #[error("{0} in the scene, expected triangles of one geometry, each once")]
    Content(&'static str),
    /// A node that its kind does not have.
    #[error(transparent)]
    Node(#[from] BlocksError),
}

/// Puts the vertices of a mesh into the scene of this root, and fits the boxes of its tree around them. The tree was
/// built from a mesh with the same triangles. A tree that was built anew is faster if they have moved far.
///
/// # Errors
/// A scene that is not one tree over all triangles of the mesh, or boxes that compressed nodes do not have. The bytes
/// are then changed in part.
pub fn refit(bytes: &mut [u8], root: u32, nodes: NodeKind, mesh: &Mesh) -> Result<(), RefitError> {
    let mut refit = Refit { bytes, nodes, mesh, blocks: HashSet::new(), has: vec![false; mesh.triangles().len()] };
    refit.child(root, 0)?;
    let missing = (0..).zip(&refit.has).find(|(index, has)| !**has && !mesh.is_degenerate(*index));
    if let Some((index, _)) = missing {
        return Err(RefitError::Missing(index));
    }
    let (blocks, found) = (refit.bytes.len() / nodes.block_bytes() as usize, refit.blocks.len());
    if found == blocks { Ok(()) } else { Err(RefitError::Others { blocks, found }) }
}

struct Refit<'s> {
    bytes: &'s mut [u8],
    nodes: NodeKind,
    mesh: &'s Mesh,
    /// The addresses of the blocks that were visited.
    blocks: HashSet<u32>,
    /// Whether each triangle was found.
    has: Vec<bool>,
}

impl Refit<'_> {
    /// Refits what a child word refers to, and returns its bounds.
    fn child(&mut self, word: u32, level: u32) -> Result<Bounds, RefitError> {
        match Child::of(word, self.nodes)? {
            Child::None => Ok(Bounds::EMPTY),
            Child::Node { .. } if level >= LEVELS => Err(RefitError::TooDeep),
            Child::Node { address } => self.node(address, level),
            Child::Leaf { address, count, .. } => self.leaf(address, count),
            Child::Instance { .. } => Err(RefitError::Content("an instance")),
            Child::Box { .. } => Err(RefitError::Content("a procedural box")),
        }
    }

    fn node(&mut self, address: u32, level: u32) -> Result<Bounds, RefitError> {
        let (nodes, mut fitted, mut all) = (self.nodes, Vec::new(), Bounds::EMPTY);
        for word in children(self.next_block(address)?, Child::Node { address }, nodes) {
            let bounds = self.child(word, level + 1)?;
            fitted.push((Aabb::new(bounds.min, bounds.max), word));
            all = all.union(bounds);
        }
        let bytes = node_bytes(&fitted, nodes)?;
        self.block(address)?.copy_from_slice(&bytes);
        Ok(all)
    }

    fn leaf(&mut self, address: u32, count: u32) -> Result<Bounds, RefitError> {
        let (mesh, nodes) = (self.mesh, self.nodes);
        let (of_block, triangles) = (nodes.triangles_per_block(), mesh.triangles().len());
        let (mut all, mut placed) = (Bounds::EMPTY, Vec::new());
        for place in 0..count {
            let address = address.saturating_add(place / of_block * nodes.block_bytes());
            let place = (place % of_block) as usize;
            let block = if place == 0 { self.next_block(address)? } else { self.block(address)? };
            if LeafTriangle::is_empty_place(block, place, nodes) {
                continue;
            }
            if LeafTriangle::geometry(block, nodes) != 0 {
                return Err(RefitError::Content("a second geometry"));
            }
            let index = LeafTriangle::of(block, place, nodes).index;
            if index as usize >= triangles {
                return Err(RefitError::Triangle { index, triangles });
            }
            let corners = mesh.corners(index);
            LeafTriangle::put_vertices(block, place, corners, nodes);
            if std::mem::replace(&mut self.has[index as usize], true) {
                return Err(RefitError::Content("a triangle that comes twice"));
            }
            all = corners.into_iter().fold(all, Bounds::with);
            placed.push((address, place));
        }
        for (address, place) in placed {
            let LeafTriangle { triangle, index } = LeafTriangle::of(self.block(address)?, place, nodes);
            let [a, b, c] = mesh.corners(index);
            if triangle != Triangle::new(a, b, c) {
                return Err(RefitError::Divided(index));
            }
        }
        Ok(all)
    }

    /// A block that was not visited yet.
    fn next_block(&mut self, address: u32) -> Result<&mut [u8], RefitError> {
        if self.blocks.insert(address) { self.block(address) } else { Err(RefitError::Repeated(address)) }
    }

    fn block(&mut self, address: u32) -> Result<&mut [u8], RefitError> {
        let bytes = self.bytes.len();
        let block =
            self.bytes.get_mut(address as usize..).and_then(|rest| rest.get_mut(..self.nodes.block_bytes() as usize));
        block.ok_or(RefitError::Address { address, bytes })
    }
}
