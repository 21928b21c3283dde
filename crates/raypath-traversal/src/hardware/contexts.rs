//! The contexts that have no ray.

use super::queue::{bits, queue};
use raypath_hdl::{Builder, Error, Module};
use std::sync::Arc;

/// The module `raypath_unit_contexts`: a free context is at `context_o` if `valid_o` is 1, and `take_i` takes it.
/// `release_i` returns `released_i`; `is_idle_o` is 1 if none is taken. After a reset all are free, and each is given
/// out once before one is given out again.
pub fn contexts(count: u32) -> Result<Arc<Module>, Error> {
    let builder = Builder::new("raypath_unit_contexts");
    let m = &builder;
    m.doc(format!("Which of {count} contexts have no ray."));
    let width = bits(count);
    let take = m.input("take_i", 1);
    let release = m.input("release_i", 1);
    let released = m.input("released_i", width);
    // The contexts from `fresh_q` on were never used, as long as `has_fresh_q` is 1.
    let fresh = m.register("fresh_q", width).reset_to(0);
    let has_fresh = m.register("has_fresh_q", 1).reset_to(1);
    has_fresh.wire().comment("contexts from fresh_q on were never used, and are not in the queue");
    let is_fresh = has_fresh.wire();
    let is_last = (take & fresh.wire().is(u64::from(count) - 1)).named("is_last");
    has_fresh.next(is_fresh & !is_last);
    fresh.next_when(take, fresh.wire() + m.constant(width, 1));
    let free = queue("raypath_unit_free", count, &[("context", width)])?;
    let inputs = [("push_i", release), ("context_i", released), ("pop_i", take & !is_fresh)];
    let outputs = m.instance("u_free", &free, &inputs);
    let taken = m.register("taken_q", width + 1).reset_to(0);
    let step = m.concat(&[(!take & release).replicate(width), take ^ release]);
    taken.next(taken.wire() + step);
    m.output("is_idle_o", taken.wire().is(0));
    m.output("valid_o", is_fresh | outputs[0]);
    m.output("context_o", is_fresh.mux(fresh.wire(), outputs[1]));
    builder.finish()
}
