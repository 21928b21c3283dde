//! The control of one skid buffer.

use raypath_hdl::{Builder, Module};
use std::sync::Arc;

/// `raypath_skid`: valid, ready and the two enables of a skid buffer's data registers.
///
/// The buffer has two registers: `front`, which the next stage sees, and `spare`, which catches whatever arrives and so
/// has it where `front` cannot leave. Its ready comes from a flip-flop, so nothing of the sink reaches the source in
/// the same cycle.
///
/// What `front` loads is what arrives, or else what `spare` holds: the same choice that `spare` makes for itself. So a
/// bit costs two multiplexers and not three.
pub fn skid() -> Result<Arc<Module>, raypath_hdl::Error> {
    let m = Builder::new("raypath_skid");
    m.doc("Control of a skid buffer: two registers, one item a cycle, ready from a flip-flop.");
    m.doc("front is what the next stage sees; spare catches what arrives, for when front cannot leave.");
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
    m.output("arrives_o", arrives);
    m.finish()
}
