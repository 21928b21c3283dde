//! Scenes whose blocks lie anywhere in memory, so that all bits of addresses and indices change.

use super::scene::BlockScene;
use crate::blocks::wide8::{self, Node8};
use crate::blocks::{Child, NODE_KIND, NodeKind};
use crate::query::Queries;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use std::collections::BTreeSet;

/// What a child of eight is that is not valid.
const INVALID_BYTE: u8 = 0b101 << 5;

/// Words of a block, in bytes.
type Words<'s> = &'s mut [[u8; 4]];

impl BlockScene {
    /// The bits of an address that tell the blocks of this scene apart. A memory may ignore the bits above them
    /// ([`Environment::ignoring_upper_bits`](super::Environment::ignoring_upper_bits)).
    pub fn address_mask(&self) -> u32 {
        self.address().next_power_of_two() - 1
    }

    /// Gives random values to the bits above [`address_mask`](Self::address_mask) in each child word that can be
    /// reached from `root`, and to the indices of triangles and instances there. In one scene of four, one child word
    /// in 64 is not valid any more, and one is missing. Returns the new word of the root.
    pub fn scatter(&mut self, root: u32, random: &mut ChaCha8Rng) -> u32 {
        let (upper, nodes) = (!self.address_mask(), self.1);
        let has_holes = random.random_range(0..4) == 0;
        for (child, block) in self.reachable(root) {
            let Some((_, indices)) = self.words_mut(child, block) else { continue };
            indices.iter_mut().for_each(|index| *index = random.random());
            self.change_children(child, block, |word| {
                let new = scattered(word, upper, random);
                match random.random_range(0..64) {
                    0 if has_holes => invalid_child(new, nodes, random),
                    1 if has_holes => 0,
                    _ => new,
                }
            });
        }
        scattered(root, upper, random)
    }

    /// Makes leaves that can be reached from `root` opaque or not, and gives indices to their geometries, and masks,
    /// flags and further indices to instances; with [`Queries::Full`], some leaves become procedural boxes. With
    /// [`Queries::None`] leaves stay, and the unit reads no other of these words. Returns the new word of the root.
    pub fn give_geometries(&mut self, root: u32, queries: Queries, random: &mut ChaCha8Rng) -> u32 {
        let nodes = self.1;
        let opacity = |word: u32, random: &mut ChaCha8Rng| match Child::of(word, nodes) {
            Ok(Child::Leaf { address, count, .. }) if queries != Queries::None => {
                let is_opaque = random.random();
                let leaf = if queries == Queries::Full && random.random_range(0..4) == 0 {
                    Child::Box { address, is_opaque }
                } else {
                    Child::Leaf { address, count, is_opaque }
                };
                leaf.word(nodes).unwrap_or(word)
            }
            _ => word,
        };
        for (child, block) in self.reachable(root) {
            self.change_children(child, block, |word| opacity(word, random));
            let Some((_, indices)) = self.words_mut(child, block) else { continue };
            match (child, indices) {
                (Child::Leaf { .. } | Child::Box { .. }, indices) => {
                    let place = nodes.geometry_word() - first_index(nodes);
                    indices[place] = random.random_range(0..3_u32).to_le_bytes();
                }
                (Child::Instance { .. }, [_, custom_and_mask, offset_and_flags]) => {
                    *custom_and_mask = random.random();
                    *offset_and_flags = random.random();
                }
                _ => {}
            }
        }
        opacity(root, random)
    }

    /// The blocks that can be reached from `root`, each once: their addresses and what they are.
    fn reachable(&mut self, root: u32) -> Vec<(Child, usize)> {
        let mask = self.address_mask();
        let (mut pending, mut seen, mut found) = (vec![root], BTreeSet::new(), Vec::new());
        while let Some(word) = pending.pop() {
            let Ok(child) = Child::of(word & mask, self.1) else { continue };
            for block in blocks(child, self.1).filter(|&block| seen.insert(block)) {
                found.push((child, block));
                self.change_children(child, block, |word| {
                    pending.push(word);
                    word
                });
            }
        }
        found
    }

    /// Changes the child words of a block at an address. Of the children of eight, the kinds change one by one, and the
    /// addresses as those of the first node and of the first other child.
    fn change_children(&mut self, child: Child, address: usize, mut change: impl FnMut(u32) -> u32) {
        let (mask, bytes) = (self.address_mask(), self.1.block_bytes());
        if self.1 != NodeKind::Wide8 || !matches!(child, Child::Node { .. }) {
            let words = self.words_mut(child, address).map(|(words, _)| words);
            return words
                .into_iter()
                .flatten()
                .for_each(|word| *word = change(u32::from_le_bytes(*word)).to_le_bytes());
        }
        let Some(block) = self.0.get_mut(address..).and_then(|rest| rest.first_chunk_mut::<128>()) else { return };
        for (number, old) in Node8::of(block).children.into_iter().enumerate().filter(|(_, old)| *old != 0) {
            let (new, is_other) = (change(old), usize::from(old % bytes != NODE_KIND));
            if new == 0 || usize::from(new % bytes != NODE_KIND) != is_other {
                // Others would come to its place.
                continue;
            }
            block[wide8::FIRST_KIND + number] = wide8::kind_byte(new % bytes, number, 0).unwrap_or(INVALID_BYTE);
            let base = &mut block.as_chunks_mut().0[4 + is_other];
            let lower = u32::from_le_bytes(*base) & (mask / bytes);
            *base = (lower | ((new & !mask) / bytes)).to_le_bytes();
        }
    }

    /// The child words and the indices of a block at an address, if the scene has it.
    fn words_mut(&mut self, child: Child, address: usize) -> Option<(Words<'_>, Words<'_>)> {
        let Self(bytes, nodes) = self;
        // The first word, and the numbers of child words and of indices after them.
        let (first, children, indices) = match child {
            Child::None => (0, 0, 0),
            Child::Node { .. } => (nodes.child_word(), if *nodes == NodeKind::Wide8 { 0 } else { 4 }, 0),
            Child::Instance { .. } => (nodes.child_word(), 1, 3),
            Child::Leaf { .. } | Child::Box { .. } => {
                (first_index(*nodes), 0, 1 + nodes.triangles_per_block() as usize)
            }
        };
        let block = bytes.get_mut(address..)?.get_mut(..nodes.block_bytes() as usize)?;
        Some(block.as_chunks_mut().0[first..first + children + indices].split_at_mut(children))
    }
}

/// The first word of a leaf's block with an index.
fn first_index(nodes: NodeKind) -> usize {
    nodes.index_word().min(nodes.geometry_word())
}

/// The addresses of the blocks that a child word refers to.
fn blocks(child: Child, nodes: NodeKind) -> impl Iterator<Item = usize> {
    let (address, count) = match child {
        Child::None => (0, 0),
        Child::Node { address } | Child::Instance { address } | Child::Box { address, .. } => (address, 1),
        Child::Leaf { address, count, .. } => (address, count.div_ceil(nodes.triangles_per_block())),
    };
    (0..count).map(move |block| (address + block * nodes.block_bytes()) as usize)
}

/// A child word with random bits where `upper` has ones; a missing child stays one.
fn scattered(child: u32, upper: u32, random: &mut ChaCha8Rng) -> u32 {
    if child == 0 { 0 } else { child & !upper | random.random::<u32>() & upper }
}

/// A child word with an address and a random kind that is not valid: no valid kind has bits 2 and 4.
pub fn invalid_child(child: u32, nodes: NodeKind, random: &mut ChaCha8Rng) -> u32 {
    child | 20 | random.random_range(0..nodes.block_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocks::children;
    use rand::SeedableRng;

    #[test]
    fn scattered_blocks_are_at_their_places_in_a_memory_that_ignores_upper_bits() {
        let (mut unchanged, mut invalid, mut missing) = (0, 0, 0);
        for seed in 0..60 {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let nodes = NodeKind::ALL[seed as usize % 3];
            let (original, root) = BlockScene::random_of(nodes, 300, &mut random);
            let mut scene = original.clone();
            let mask = scene.address_mask();
            let scattered = scene.scatter(root, &mut random);
            assert!(scattered & mask == root && scattered != root);
            let mut pending = vec![root];
            while let Some(word) = pending.pop() {
                let Ok(node @ Child::Node { address }) = Child::of(word, nodes) else { continue };
                let words = |scene: &BlockScene| children(&scene.0[address as usize..], node, nodes);
                for (old, new) in words(&original).into_iter().zip(words(&scene)) {
                    pending.push(old);
                    match Child::of(new, nodes) {
                        Err(_) => invalid += 1,
                        Ok(Child::None) if old != 0 => missing += 1,
                        Ok(_) => {
                            assert_eq!(new & mask, old);
                            unchanged += 1;
                        }
                    }
                }
            }
        }
        let is_varied = unchanged > 1_000 && invalid > 5 && missing > 5;
        assert!(is_varied, "{unchanged} words, {invalid} are not valid, {missing} are missing");
    }
}
