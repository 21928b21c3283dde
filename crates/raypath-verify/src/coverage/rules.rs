//! The rules of `docs/reference/semantics.md` that a job exercises. This code decides what is counted, not what is
//! right.

mod beats;
mod boxes;
mod rounded;
mod triangles;

pub use beats::{AccumulatorState, RULES_AT_ENTRY, rules_at_entry, rules_at_exit};
pub use boxes::{PERMUTATIONS, box_rules, permutation};
pub use rounded::{Rounded, Rule};
pub use triangles::triangle_rules;
