//! Scenes in the memory of the traversal unit.

use raypath_ops::Rules;
use raypath_traversal::blocks::NodeKind;
use raypath_traversal::state::status;
use raypath_traversal::{Memory, MemoryError, Queries, RayRequest, StepParameters, Unit, UnitFeatures, ray_flags};
use std::cell::Cell;

/// The blocks after which the memory has errors alone, because a scene with a cycle has no end before `VISIT_LIMIT`.
const MAX_BLOCKS: u32 = 2000;
/// The flags of a ray by the bits of a byte.
const RAY_FLAGS: [(u8, u32); 5] = [
    (1, ray_flags::TERMINATE_ON_FIRST_HIT),
    (2, ray_flags::CULL_BACK_FACING_TRIANGLES),
    (4, ray_flags::CULL_FRONT_FACING_TRIANGLES),
    (64, ray_flags::CULL_OPAQUE),
    (128, ray_flags::CULL_NO_OPAQUE),
];
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
        flags: RAY_FLAGS.into_iter().filter(|(bit, _)| flags & bit != 0).fold(0, |all, (_, flag)| all | flag),
        cull_mask: 1 << (flags & 7),
        root: word(8),
        base: 0,
    };
    let node = if node & 1 == 0 { NodeKind::Wide4 } else { NodeKind::Quantised };
    let instances = node == NodeKind::Wide4 && flags & 8 != 0;
    let queries = if flags & 32 != 0 { Queries::Flags } else { Queries::None };
    let features = UnitFeatures { instances, barycentrics: flags & 16 != 0, queries, ..UnitFeatures::OFF };
    let parameters = StepParameters { node, features, ..StepParameters::default() };
    let mut unit = Unit::new(Rules::Paper, parameters);
    let mut trace = || {
        let memory = Bounded { bytes: memory, left: Cell::new(MAX_BLOCKS) };
        (unit.trace(&memory, &ray), memory.left.get())
    };
    let (reply, left) = trace();
    assert!(reply.status <= status::LIMIT && reply.hit.is_some() == (reply.status == 1), "{reply:?}");
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
    fn block(&self, address: u64, bytes: u32) -> Result<&[u8], MemoryError> {
        let left = self.left.get().checked_sub(1).ok_or(MemoryError(address))?;
        self.left.set(left);
        self.bytes.block(address, bytes)
    }
}
