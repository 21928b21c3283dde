//! The barycentric coordinates of hits.

use super::connect::hold;
use super::parameters::UnitParameters;
use super::queue::bits;
use raypath_float::{DivSqrt, Format, decode, encode};
use raypath_hdl::{Builder, Error, Module, Wire};
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
    let enters = m.forward("enters", 1);
    let ends = (enters.wire() & is_second.wire()).named("ends");
    let take = (valid & (!busy.wire() | ends)).named("take");
    busy.next(take | (busy.wire() & !ends));
    is_second.next_when(enters.wire(), !is_second.wire());
    let context = hold("context_q", take, context);

    m.section("The operands");
    let divides = m.forward("divides", 1);
    let has_operands = m.register("has_operands_q", 1).reset_to(0);
    enters.drive(busy.wire() & (!has_operands.wire() | divides.wire()));
    let enters = enters.wire();
    has_operands.next(enters | (has_operands.wire() & !divides.wire()));
    let encoder = encode(Format::BINARY32)?;
    let operand = |name: &str, wire: Wire<'_>| {
        let recoded = m.instance(&format!("u_encode_{name}"), &encoder, &[("ieee_i", wire)])[0];
        hold(&format!("{name}_q"), enters, recoded)
    };
    let a = operand("dividend", is_second.wire().mux(v_num, u_num));
    let b = operand("divisor", t_denom);
    let tag = hold("operands_tag_q", enters, m.concat(&[context, is_hit, is_second.wire()]));

    m.section("Division");
    let divider = DivSqrt::Quotient.pipelined(Format::BINARY32, divider_latency, tag.width())?;
    let moves = m.forward("moves", 1);
    let given = [("valid_i", has_operands.wire()), ("ready_i", moves.wire()), ("a_i", a), ("b_i", b), ("tag_i", tag)];
    let results = m.instance("u_divider", &divider, &given);
    let (has_quotient, result, tag) = (results[1], results[2], results[3]);
    divides.drive(results[0]);
    let quotient = m.instance("u_decode", &decode(Format::BINARY32)?, &[("recoded_i", result)])[0];
    let quotient = (quotient & tag.bit(1).replicate(32)).named("weight");

    m.section("Both quotients: u waits for v");
    let is_complete = (has_quotient & tag.bit(0)).named("is_complete");
    moves.drive(!is_complete | ready);
    let u = hold("u_q", has_quotient & !tag.bit(0), quotient);

    m.output("take_o", take);
    m.output("valid_o", is_complete);
    m.output("context_o", tag.upper(tag.width() - 2));
    m.output("u_o", u);
    m.output("v_o", quotient);
    builder.finish()
}
