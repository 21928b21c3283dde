//! The barycentric coordinates of hits.

use super::connect::hold;
use super::division::{Division, Operands, divide};
use super::parameters::UnitParameters;
use super::queue::bits;
use raypath_hdl::{Builder, Error, Module};
use std::sync::Arc;

/// The module `raypath_unit_weights`, which divides twice for each ray: u and v.
///
/// A ray that has ended waits where `valid_i` is 1, and is taken where `take_o` is 1, with `context_i`. In the next
/// cycle, and until the next ray is taken, `u_num_i`, `v_num_i`, `t_denom_i` and `is_hit_i` are those of its hit. Its
/// weights, 0 without a hit, are there where `valid_o` is 1, until `ready_i` is 1: `u_o` and `v_o` with `context_o`.
pub fn weights(parameters: UnitParameters) -> Result<Arc<Module>, Error> {
    let UnitParameters { contexts, divider_latency, .. } = parameters;
    let builder = Builder::new("raypath_unit_weights");
    let m = &builder;
    m.doc("The weights of the vertices of hits, from one divider that each ray uses twice.");
    let valid = m.input("valid_i", 1);
    let context = m.input("context_i", bits(contexts));
    let [u_num, v_num, t_denom] = ["u_num_i", "v_num_i", "t_denom_i"].map(|name| m.input(name, 32));
    let is_hit = m.input("is_hit_i", 1);
    let ready = m.input("ready_i", 1);

    m.section("The ray whose operands enter the divider: of u first, then of v");
    let busy = m.register("busy_q", 1).reset_to(0);
    let is_second = m.register("is_second_q", 1).reset_to(0);
    let ends = m.forward("ends", 1);
    let take = (valid & (!busy.wire() | ends.wire())).named("take");
    busy.next(take | (busy.wire() & !ends.wire()));
    let context = hold("context_q", take, context);

    m.section("The operands, and their division");
    let moves = m.forward("moves", 1);
    let operands = Operands {
        valid: busy.wire(),
        dividend: is_second.wire().mux(v_num, u_num),
        divisor: t_denom,
        tag: vec![context, is_hit, is_second.wire()],
    };
    let Division { enters, valid: has_quotient, quotient, tag, .. } =
        divide(divider_latency, operands, Some(moves.wire()))?;
    is_second.next_when(enters, !is_second.wire());
    ends.drive(enters & is_second.wire());
    let quotient = (quotient & tag.bit(1).replicate(32)).named("weight");

    m.section("Both quotients: u waits for v");
    let is_complete = (has_quotient & tag.bit(0)).named("is_complete");
    moves.drive(!is_complete | ready);
    let u = hold("u_q", has_quotient & !tag.bit(0), quotient).comment("until v comes, which is next in the divider");

    m.output("take_o", take);
    m.output("valid_o", is_complete);
    m.output("context_o", tag.upper(tag.width() - 2));
    m.output("u_o", u);
    m.output("v_o", quotient);
    builder.finish()
}
