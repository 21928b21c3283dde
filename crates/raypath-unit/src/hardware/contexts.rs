//! The contexts that have no ray.

use super::queue::{bits, queue};
use raypath_hdl::{Builder, Error, Module};
use std::sync::Arc;

/// The module `raypath_unit_contexts`: a free context is at `context_o` if `valid_o` is 1, and `take_i` takes it.
/// `release_i` returns `released_i`. After a reset all are free, and each is given out once before one is given out
/// again.
pub fn contexts(count: u32) -> Result<Arc<Module>, Error> {
    let builder = Builder::new("raypath_unit_contexts");
    let m = &builder;
    m.doc(format!("Which of {count} contexts have no ray."));
    let width = bits(count);
    let take = m.input("take_i", 1);
    let release = m.input("release_i", 1);
    let released = m.input("released_i", width);
    // The contexts from here on were never used.
    let fresh = m.register("fresh_q", bits(count + 1)).reset_to(0);
    let is_fresh = (!fresh.wire().is(count.into())).named("is_fresh");
    fresh.next_when(take & is_fresh, fresh.wire() + m.constant(bits(count + 1), 1));
    let free = queue("raypath_unit_free", count, &[("context", width)])?;
    let inputs = [("push_i", release), ("context_i", released), ("pop_i", take & !is_fresh)];
    let outputs = m.instance("u_free", &free, &inputs);
    m.output("valid_o", is_fresh | outputs[0]);
    m.output("context_o", is_fresh.mux(fresh.wire().lower(width), outputs[1]));
    builder.finish()
}
