//! Trees of keys and of boxes: what a node has, and where a search goes from it.

use super::SEARCH_BLOCK;
use super::image::{ImageError, SearchImage};
use crate::blocks::BOX_WORDS;
use raypath_ops::operations::key_compare::{KeyCompare, KeyCompareInput};
use raypath_ops::operations::point_in_box::{PointInBox, PointInBoxInput};
use raypath_ops::{Aabb, Binary32, Operation};

/// Bytes of a node: two blocks. It has 32 words of 32 bits, little-endian:
///
/// | word | contents |
/// |---|---|
/// | 0 to 29, of keys | separators in binary32, ascending; NaN where there are fewer. Child i has the keys that reach i of them |
/// | 0 to 23, of boxes | for each of four children the least x, y, z and the greatest; NaN where there is none |
/// | 30 | the index of the first child, from 0 for the root; in a leaf, that of a vector |
/// | 31 | bit 0: it is a leaf |
///
/// Children follow each other. In a leaf of keys, the vectors of child i begin at word 30 + i; in one of boxes, child i has
/// the four vectors from word 30 + 4 × i on.
pub const NODE_BYTES: u32 = 2 * SEARCH_BLOCK;

/// Blocks of a node.
pub(crate) const NODE_BLOCKS: u32 = NODE_BYTES / SEARCH_BLOCK;

/// The opcodes of nodes in the unit's datapath.
pub(crate) const KEYS_OPCODE: u64 = 5;
pub(crate) const BOXES_OPCODE: u64 = 6;

/// Separators of a node of keys.
pub(crate) const SEPARATORS: usize = 30;

/// The branches that a search keeps. One that needs more ends as with an error of the memory.
pub(crate) const BRANCHES: usize = 32;

/// Vectors of a child in a leaf of boxes.
const PER_BOX: u32 = 4;

/// The children of a node that are read next, or the vectors of a leaf.
#[derive(Debug, Clone, Copy, Default)]
pub struct Branch {
    /// The index of child 0.
    pub first: u32,
    /// A bit for each child.
    pub children: u8,
    pub is_leaf: bool,
}

impl Branch {
    /// Where a search goes from a node. `query` are the first words of the query's block.
    pub fn of_node(words: &[u32; 32], query: [f32; 4], is_keys: bool) -> Self {
        let number = |word: usize| f32::from_bits(words[word]);
        let [x, y, z, key] = query;
        let (first, is_leaf) = (words[30], words[31] & 1 != 0);
        if is_keys {
            let separator = |k| if k < SEPARATORS { number(k) } else { f32::NAN };
            let input = KeyCompareInput { key: key.into(), separator: std::array::from_fn(|k| separator(k).into()) };
            let child: u32 = KeyCompare.run(Binary32, input, ()).0.child_index.into();
            return Self { first: first.wrapping_add(child), children: 1, is_leaf };
        }
        let aabb: [Aabb<Binary32>; 4] = std::array::from_fn(|k| {
            let bounds = |from: usize| std::array::from_fn(|axis| number(BOX_WORDS * k + from + axis));
            Aabb::new(bounds(0), bounds(3))
        });
        let inside = PointInBox.run(Binary32, PointInBoxInput { point: [x, y, z].into(), aabb }, ()).0.is_inside;
        let children = (0..4).map(|k| u8::from(inside.to_array()[k]) << k).sum();
        Self { first, children, is_leaf }
    }

    /// The indices of its nodes, or of the vectors of a leaf of boxes.
    pub fn indices(self) -> impl Iterator<Item = u32> {
        let per_child = if self.is_leaf { PER_BOX } else { 1 };
        let of_child = move |k: u32| (k * per_child..(k + 1) * per_child).map(move |k| self.first.wrapping_add(k));
        (0..4).filter(move |k| self.children >> k & 1 == 1).flat_map(of_child)
    }
}

impl SearchImage {
    /// Places a tree of keys in ascending order, and returns the address of its root. Vector i has key i.
    ///
    /// # Errors
    /// A key that is NaN or less than the one before; more than 4 GiB.
    pub fn keys(&mut self, keys: &[f32]) -> Result<u32, ImageError> {
        if let Some(place) = (0..keys.len()).find(|&k| keys[k].is_nan() || (k > 0 && keys[k] < keys[k - 1])) {
            return Err(ImageError::Order(place));
        }
        let separators = |keys: &[f32]| {
            let mut words = [f32::NAN.to_bits(); 32];
            words.iter_mut().zip(keys).for_each(|(word, key)| *word = key.to_bits());
            words
        };
        let mut levels = vec![keys.chunks(SEPARATORS).map(separators).collect::<Vec<_>>()];
        let mut least: Vec<f32> = keys.iter().step_by(SEPARATORS).copied().collect();
        while least.len() > 1 {
            levels.push(least.chunks(SEPARATORS + 1).map(|keys| separators(&keys[1..])).collect());
            least = least.iter().step_by(SEPARATORS + 1).copied().collect();
        }
        self.tree(levels, SEPARATORS, SEPARATORS + 1)
    }

    /// Places a tree of boxes around all places whose distance to a point is at most the radius, and returns the address
    /// of its root. Vector i has point i; [`order_of_boxes`] puts points that are near in the same boxes.
    ///
    /// # Errors
    /// More than 4 GiB.
    pub fn boxes(&mut self, points: &[[f32; 3]], radius: f32) -> Result<u32, ImageError> {
        // Distances are rounded, and squares of very small ones are 0.
        let margin = f64::from(radius) * (1.0 + 1.0 / f64::from(1 << 20)) + 1e-21;
        let of_point = |point: &[f32; 3]| {
            let least = point.map(|x| ((f64::from(x) - margin) as f32).next_down());
            (least, point.map(|x| ((f64::from(x) + margin) as f32).next_up()))
        };
        let around = |boxes: &[([f32; 3], [f32; 3])]| {
            let (mut least, mut greatest) = boxes[0];
            for (low, high) in boxes {
                least = std::array::from_fn(|axis| least[axis].min(low[axis]));
                greatest = std::array::from_fn(|axis| greatest[axis].max(high[axis]));
            }
            (least, greatest)
        };
        let node = |boxes: &[([f32; 3], [f32; 3])]| {
            let mut words = [f32::NAN.to_bits(); 32];
            let bounds = boxes.iter().flat_map(|(least, greatest)| least.iter().chain(greatest));
            words.iter_mut().zip(bounds).for_each(|(word, bound)| *word = bound.to_bits());
            words
        };
        let points: Vec<_> = points.iter().map(of_point).collect();
        let mut boxes: Vec<_> = points.chunks(PER_BOX as usize).map(around).collect();
        let mut levels = Vec::new();
        while levels.is_empty() || boxes.len() > 1 {
            levels.push(boxes.chunks(4).map(node).collect::<Vec<_>>());
            boxes = boxes.chunks(4).map(around).collect();
        }
        self.tree(levels, 4 * PER_BOX as usize, 4)
    }

    /// Places nodes, the leaves first, with the links to their children.
    fn tree(&mut self, mut levels: Vec<Vec<[u32; 32]>>, of_leaf: usize, of_node: usize) -> Result<u32, ImageError> {
        if levels[0].is_empty() {
            levels[0].push([f32::NAN.to_bits(); 32]);
        }
        let mut end: usize = levels.iter().map(Vec::len).sum();
        let address = self.reserve(end as u64 * u64::from(NODE_BYTES))?;
        let mut below = None;
        for level in levels {
            let begin = end - level.len();
            for (number, mut words) in level.into_iter().enumerate() {
                let first = below.map_or(of_leaf * number, |below| below + of_node * number);
                words[30..].copy_from_slice(&[first as u32, below.is_none().into()]);
                self.write(address + (begin + number) as u32 * NODE_BYTES, &words);
            }
            below = Some(begin);
            end = begin;
        }
        Ok(address)
    }
}

/// The order of points in which those of the same box are near: by halves along the axis of the greatest extent.
pub fn order_of_boxes(points: &[[f32; 3]]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    halve(points, &mut order);
    order
}

fn halve(points: &[[f32; 3]], indices: &mut [u32]) {
    if indices.len() <= PER_BOX as usize {
        return;
    }
    let along = |index: &u32, axis: usize| points[*index as usize][axis];
    let extent = |axis: usize| {
        let of_axis = || indices.iter().map(|index| along(index, axis));
        of_axis().fold(f32::NEG_INFINITY, f32::max) - of_axis().fold(f32::INFINITY, f32::min)
    };
    let axis = (0..3).max_by(|a, b| extent(*a).total_cmp(&extent(*b))).unwrap_or(0);
    // The first half is full, so that no box has points of both.
    let half = indices.len().next_power_of_two() / 2;
    indices.select_nth_unstable_by(half, |a, b| along(a, axis).total_cmp(&along(b, axis)).then(a.cmp(b)));
    let (first, second) = indices.split_at_mut(half);
    halve(points, first);
    halve(points, second);
}
