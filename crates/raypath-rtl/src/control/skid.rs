//! The control of one skid buffer.

use raypath_hdl::{Builder, Module};
use std::sync::Arc;

/// `raypath_skid`: valid, ready and the three enables of a skid buffer's data registers.
///
/// The buffer has two registers: `front`, which the next stage sees, and `spare`, which catches what arrives while
/// `front` cannot leave. Its ready comes from a flip-flop, so nothing of the sink reaches the source in the same cycle.
pub fn skid() -> Result<Arc<Module>, raypath_hdl::Error> {
    let m = Builder::new("raypath_skid");
    m.doc("Control of a skid buffer: two registers, one item a cycle, ready from a flip-flop.");
    m.doc("front is what the next stage sees; spare catches what arrives while front cannot leave.");
    let valid = m.input("valid_i", 1);
    let ready_after = m.input("ready_i", 1);

    let front_full = m.register("front_full_q", 1).reset_to(0);
    let spare_empty = m.register("spare_empty_q", 1).reset_to(1);

    let arrives = (valid & spare_empty.wire()).named("arrives");
    let leaves = (!front_full.wire() | ready_after).named("leaves").comment("front is free after this edge");
    let refill = (arrives | !spare_empty.wire()).named("refill");
    front_full.next(!leaves | refill);
    spare_empty.next(spare_empty.wire().mux(leaves | !arrives, leaves));

    m.output("ready_o", spare_empty.wire());
    m.output("valid_o", front_full.wire());
    m.output("load_front_o", leaves & refill);
    m.output("load_spare_o", arrives & !leaves);
    m.finish()
}
