//! The control of the exit of a pipeline that cannot stall.

use raypath_hdl::{Builder, Module};
use std::sync::Arc;

/// `raypath_exit`: which of its registers the exit FIFO loads. `depth` is how many items it stores behind the one that
/// the sink sees, 1 to 64.
///
/// An arriving item goes straight to `front` where nothing waits, so that the FIFO adds no cycle. Places are named by
/// one-hot pointers, which are the write enables and the read selects as they stand.
pub fn exit(depth: u32) -> Result<Arc<Module>, raypath_hdl::Error> {
    let m = Builder::new("raypath_exit");
    m.doc(format!("Control of the exit: front, which the sink sees, and a FIFO of {depth} behind it."));
    m.doc("Credits see to it that nothing arrives while all are full.");
    let valid = m.input("valid_i", 1);
    let ready_after = m.input("ready_i", 1);

    let front_full = m.register("front_full_q", 1).reset_to(0);
    let waiting = m.register("waiting_q", u32::BITS - depth.leading_zeros()).reset_to(0);
    let write = m.register("write_q", depth).reset_to(1);
    let read = m.register("read_q", depth).reset_to(1);

    let leaves = (!front_full.wire() | ready_after).named("leaves").comment("front is free after this edge");
    let stored = waiting.wire().any().named("stored");
    let fetches = (leaves & stored).named("fetches");
    let stores = (valid & (stored | !leaves)).named("stores");
    let load_front = (leaves & (stored | valid)).named("load_front");
    front_full.next(!leaves | load_front);
    let width = waiting.wire().width();
    waiting.next(waiting.wire() + stores.extend(width) - fetches.extend(width));
    if depth > 1 {
        for (pointer, turns) in [(write, stores), (read, fetches)] {
            let wire = pointer.wire();
            pointer.next_when(turns, m.concat(&[wire.lower(depth - 1), wire.top()]));
        }
    } else {
        write.next(write.wire());
        read.next(read.wire());
    }

    m.output("valid_o", front_full.wire());
    m.output("load_front_o", load_front);
    m.output("from_store_o", stored);
    m.output("store_o", write.wire() & stores.replicate(depth));
    m.output("read_o", read.wire());
    m.finish()
}
