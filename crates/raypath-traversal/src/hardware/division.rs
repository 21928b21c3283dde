//! A divider with a register for its operands, because their encoders are slow.

use super::connect::{delay, hold};
use raypath_float::{DivSqrt, Format, decode, encode};
use raypath_hdl::{Error, Wire};

/// Numbers to divide where `valid` is 1, and the words that go along with them.
pub struct Operands<'m> {
    pub valid: Wire<'m>,
    pub dividend: Wire<'m>,
    pub divisor: Wire<'m>,
    pub tag: Vec<Wire<'m>>,
}

/// Operands enter where `enters` is 1: where they are valid and `ready` is 1. A quotient is there where `valid` is 1.
pub struct Division<'m> {
    pub ready: Wire<'m>,
    pub enters: Wire<'m>,
    pub valid: Wire<'m>,
    pub quotient: Wire<'m>,
    pub tag: Wire<'m>,
}

/// Divides in binary32. A quotient leaves where `moves` is 1; without this wire, each leaves at once.
pub fn divide<'m>(latency: u32, operands: Operands<'m>, moves: Option<Wire<'m>>) -> Result<Division<'m>, Error> {
    let Operands { valid, dividend, divisor, tag } = operands;
    let m = valid.builder();
    let one = m.constant(1, 1);
    let has_operands = m.register("has_operands_q", 1).reset_to(0);
    has_operands.wire().comment("in registers before the divider, because their encoders are slow");
    let divides = moves.map(|_| m.forward("divides", 1));
    let (ready, enters) = divides.map_or((one, valid), |divides| {
        let ready = (!has_operands.wire() | divides.wire()).named("ready");
        (ready, (valid & ready).named("enters"))
    });
    has_operands.next(divides.map_or(enters, |divides| enters | (has_operands.wire() & !divides.wire())));
    let keep = |name: &str, wire| if moves.is_some() { hold(name, enters, wire) } else { delay(name, wire) };
    let encoder = encode(Format::BINARY32)?;
    let recoded = |name: &str, number| {
        let number = m.instance(&format!("u_encode_{name}"), &encoder, &[("ieee_i", number)])[0];
        keep(&format!("{name}_q"), number)
    };
    let (a, b) = (recoded("dividend", dividend), recoded("divisor", divisor));
    let tag = keep("operands_tag_q", m.concat(&tag));

    let divider = DivSqrt::Quotient.pipelined(Format::BINARY32, latency, tag.width())?;
    let (valid, moves) = (has_operands.wire(), moves.unwrap_or(one));
    let given = [("valid_i", valid), ("ready_i", moves), ("a_i", a), ("b_i", b), ("tag_i", tag)];
    let results = m.instance("u_divider", &divider, &given);
    match divides {
        Some(divides) => divides.drive(results[0]),
        None => m.unused("unused_ready", &results[..1]),
    }
    let quotient = m.instance("u_decode", &decode(Format::BINARY32)?, &[("recoded_i", results[2])])[0];
    Ok(Division { ready, enters, valid: results[1], quotient, tag: results[3] })
}
