//! The module that clock gates are instances of.

/// The name of the module that clock gates are instances of. A design can replace it by another one with the same
/// ports.
pub const CLOCK_GATE: &str = "raypath_clock_gate";

/// Its text, without the head.
pub const CLOCK_GATE_TEXT: &str = include_str!("raypath_clock_gate.sv");

/// Its head comment.
pub const CLOCK_GATE_DOC: &str = "A clock gate: clk_o has the pulses of clk_i before whose rising edge enable_i is 1. \
                                  The latch holds the enable while the clock is 1, so a pulse is never cut. For \
                                  synthesis, replace this module by a wrapper of the library's integrated clock gate \
                                  (latch_posedge) with the same ports.";
