//! Scenes in the memory of the traversal unit.

use raypath_ops::Rules;
use raypath_traversal::blocks::NodeKind;
use raypath_traversal::{Memory, MemoryError, RayRequest, StepParameters, Unit, UnitFeatures};
use std::cell::Cell;

/// The blocks after which the memory has errors alone, because a scene with a cycle has no end before `VISIT_LIMIT`.
const MAX_BLOCKS: u32 = 2000;
/// The bytes of an input before those of the memory: a ray.
const HEADER: usize = 38;

/// A ray through any bytes of memory ends, with a hit or without, and its answer is that of any other memory of the
/// same bytes.
pub fn scene(bytes: &[u8]) -> bool {
    let Some((header, memory)) = bytes.split_first_chunk::<HEADER>() else { return false };
    let (words, [flags, node]) = header.split_at(HEADER - 2) else { return false };
    let word = |index: usize| words.as_chunks().0.get(index).copied().map_or(0, u32::from_le_bytes);
    let number = |index: usize| f32::from_bits(word(index));
    let ray = RayRequest {
        origin: [0, 1, 2].map(number),
        direction: [3, 4, 5].map(number),
        t_min: number(6),
        t_max: number(7),
        any_hit: flags & 1 != 0,
        cull_back: flags & 2 != 0,
        cull_front: flags & 4 != 0,
        root: word(8),
    };
    let node = if node & 1 == 0 { NodeKind::Wide4 } else { NodeKind::Quantised };
    let instances = node == NodeKind::Wide4 && flags & 8 != 0;
    let features = UnitFeatures { instances, barycentrics: flags & 16 != 0 };
    let parameters = StepParameters { node, features, ..StepParameters::default() };
    let mut unit = Unit::new(Rules::Paper, parameters);
    let mut trace = || {
        let memory = Bounded { bytes: memory, left: Cell::new(MAX_BLOCKS) };
        (unit.trace(&memory, &ray), memory.left.get())
    };
    let (reply, left) = trace();
    assert!(reply.status <= 3 && reply.hit.is_some() == (reply.status == 1), "{reply:?}");
    assert!(reply.nodes <= MAX_BLOCKS + 1 && reply.triangles <= 8 * (MAX_BLOCKS + 1), "{reply:?}");
    // Nothing of a ray remains for the next. As text, because a NaN differs from itself.
    assert_eq!(format!("{:?}", trace()), format!("{:?}", (reply, left)));
    reply.status < 2
}

/// A memory that has errors alone after some blocks.
struct Bounded<'b> {
    bytes: &'b [u8],
    left: Cell<u32>,
}

impl Memory for Bounded<'_> {
    fn block(&self, address: u32, bytes: u32) -> Result<&[u8], MemoryError> {
        let left = self.left.get().checked_sub(1).ok_or(MemoryError(address))?;
        self.left.set(left);
        self.bytes.block(address, bytes)
    }
}
