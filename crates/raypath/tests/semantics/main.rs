//! What the datapath answers on every edge that `docs/reference/semantics.md` rules on, and what
//! `docs/integration/ports.md` promises.
//!
//! Expected values come from the text of a rule or from exact arithmetic, never from a model; and each is asked of the
//! functional model, the cycle-exact model and the netlist alike ([`answers::answers`]).

mod answers;
mod exact;
mod random;
#[path = "../recorded/mod.rs"]
mod recorded;

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
mod exact_boxes;
mod exact_sums;
mod exact_triangles;
mod golden_vectors;
mod lockstep;
mod no_combinational_path;
mod original_faults;
mod rounding;
mod timing;
mod unsupported_opcode;

use raypath::verify::oracle;
