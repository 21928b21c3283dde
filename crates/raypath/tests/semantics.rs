//! The rulings of `docs/reference/semantics.md` and the properties of `docs/integration/ports.md`.
//!
//! Expected values come from the text of a rule or from exact arithmetic, never from a model. Each test runs on the
//! functional model, the cycle-exact model and the netlist ([`answers::answers`]).

mod answers;
mod random;
mod rule_1_direction;
mod rule_2_slab_nan;
mod rule_3_extent;
mod rule_4_touching;
mod rule_5_order;
mod rule_6_triangle_hit;
mod rule_7_masks;
mod rule_8_reporting;

mod accumulators;
mod canonical_nan;
mod golden_vectors;
mod no_combinational_path;
mod oracle;
mod original_faults;
mod timing;
