//! Trees of compressed wide nodes that others build.

use crate::blocks::{Blocks, BlocksError, check_levels, check_size};
use crate::mesh::Mesh;
use raypath_ops::Triangle;
use raypath_traversal::blocks::{LeafTriangle, NodeKind};
use thiserror::Error;

/// The reason why compressed wide nodes make no scene.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CwbvhError {
    /// A node of others than theirs.
    #[error("node {number}: {problem}")]
    Node {
        /// Its number.
        number: usize,
        /// The problem.
        problem: String,
    },
    /// A tree that is too large or too deep.
    #[error(transparent)]
    Blocks(#[from] BlocksError),
}

impl Blocks {
    /// The blocks of nodes in the form of the crate `obvhs` (`CwBvhNode`, [80 bytes](raypath_traversal::blocks::wide8))
    /// over primitives, which are triangles of a mesh: one opaque geometry. The first node is the root, and children
    /// come after their parents. Node `i` becomes block `i`. Its bytes stay, but for those at 20 to 23: they were the
    /// number of its first primitive, and are the block of its first leaf.
    /// [Degenerate](Mesh::is_degenerate) triangles are left out of leaves.
    ///
    /// Boxes are as tight as their builder made them: a ray that hits a triangle outside its box may miss it.
    ///
    /// # Errors
    /// A child or a primitive that is not there, or a tree that is too large or too deep.
    pub fn of_cwbvh(nodes: &[[u8; 80]], primitives: &[u32], mesh: &Mesh) -> Result<Self, CwbvhError> {
        const KIND: NodeKind = NodeKind::Wide8;
        const BYTES: usize = KIND.block_bytes() as usize;
        let nodes = if nodes.is_empty() { &[[0; 80]] } else { nodes };
        let (mut blocks, mut leaves, mut levels) = (vec![[0; BYTES]; nodes.len()], Vec::new(), vec![1; nodes.len()]);
        for (number, (node, block)) in nodes.iter().zip(&mut blocks).enumerate() {
            let refused = |problem| CwbvhError::Node { number, problem };
            let word = |first: usize| u32::from_le_bytes([0, 1, 2, 3].map(|byte| node[first + byte])) as usize;
            let (child, primitive) = (word(16), word(20));
            let is_node = |kind: u8| kind >> 3 == 0b00111;
            let count = node[24..32].iter().filter(|kind| is_node(**kind)).count();
            if count > 0 && (child <= number || child + count > nodes.len()) {
                let last = nodes.len() - 1;
                return Err(refused(format!("{count} nodes from {child} on, expected ones after it, up to {last}")));
            }
            let below = levels[number] + 1;
            levels.iter_mut().skip(child).take(count).for_each(|level| *level = below.max(*level));
            block[..80].copy_from_slice(node);
            block[20..24].copy_from_slice(&((nodes.len() + leaves.len() / BYTES) as u32).to_le_bytes());
            for kind in block[24..32].iter_mut().filter(|kind| **kind != 0 && !is_node(**kind)) {
                let first = primitive + usize::from(*kind % 32);
                let count = match *kind >> 5 {
                    0b001 => 1,
                    0b011 => 2,
                    0b111 => 3,
                    _ => return Err(refused(format!("a child of kind {kind:#010b}, expected 001, 011 or 111 first"))),
                };
                let leaf = primitives.get(first..first + count).ok_or_else(|| {
                    refused(format!("{count} primitives from {first} on, expected some of the {}", primitives.len()))
                })?;
                let all = mesh.triangles().len();
                if let Some(index) = leaf.iter().find(|index| **index as usize >= all) {
                    return Err(refused(format!("triangle {index}, expected less than {all}, as the mesh has")));
                }
                let triangle = |&index: &u32| {
                    let [a, b, c] = mesh.corners(index);
                    (!mesh.is_degenerate(index)).then(|| LeafTriangle { triangle: Triangle::new(a, b, c), index })
                };
                let triangles: Vec<_> = leaf.iter().filter_map(triangle).collect();
                *kind = if triangles.is_empty() { 0 } else { (((1 << triangles.len()) - 1) << 5) | (*kind % 32) };
                leaves.extend(LeafTriangle::to_blocks(&triangles, 0, KIND).0);
            }
        }
        let levels = KIND.node_levels(KIND.children()) * levels.into_iter().max().unwrap_or(0);
        check_levels(levels)?;
        let bytes = [blocks.into_flattened(), leaves].concat();
        check_size(bytes.len() as u64)?;
        Ok(Self::of_bytes(bytes, KIND, nodes.len(), levels))
    }
}
