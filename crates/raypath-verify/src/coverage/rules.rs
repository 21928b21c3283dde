//! The rules of `docs/reference/semantics.md` that a job exercises. This code decides what is counted, not what is
//! right.

mod beats;
mod boxes;
mod declare;
mod rounded;
mod triangles;

pub use beats::{AccumulatorState, BeatRule};
pub use boxes::{BoxRule, PERMUTATIONS, permutation};
pub use rounded::Rounded;
pub use triangles::TriangleRule;
