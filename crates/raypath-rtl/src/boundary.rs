//! The registers after a stage: what each operation hands on, chosen by opcode, in two registers a place.

use crate::error::Error;
use crate::graph::{NodeId, Traced};
use crate::place::{Layout, Place};
use crate::plan::Plan;
use raypath_hdl::{Builder, Label, Module, Wire};
use std::sync::Arc;

/// Bits of the opcode.
pub const OPCODE_WIDTH: u32 = 2;

/// The name of a number register at a port.
pub fn number(place: usize) -> String {
    format!("num_{place}")
}

/// How comments and labels call an operation's opcode: `OpQuadbox`.
pub fn label(traced: &Traced) -> Label {
    let mut name = String::from("Op");
    for word in traced.name.split('_') {
        let (first, rest) = word.split_at(word.len().min(1));
        name.push_str(&first.to_uppercase());
        name.push_str(rest);
    }
    Label { name, value: traced.opcode }
}

/// What a value of an operation is in a stage.
pub trait Wires<'m> {
    /// The wire, under the name that the algorithm has for it.
    fn named(&mut self, op: usize, id: NodeId) -> Result<Wire<'m>, Error>;
    /// The same net without that name: operations that share it have different names for it.
    fn shared(&mut self, op: usize, id: NodeId) -> Result<Wire<'m>, Error>;
}

/// A choice by opcode: whose it is, what tells it from other nets, and the value; `true` inverts its sign.
pub type Arm<K> = (usize, K, NodeId, bool);

/// The value of the job's operation among `arms`. No multiplexer where all are the same net; an opcode that nobody
/// uses takes what the first one does.
pub fn by_opcode<'m, K: PartialEq>(
    m: &'m Builder,
    opcode: Wire<'m>,
    operations: &[Traced],
    arms: &[Arm<K>],
    wires: &mut dyn Wires<'m>,
) -> Result<Option<Wire<'m>>, Error> {
    let signed = |wire: Wire<'m>, invert: bool| if invert { negate(wire) } else { wire };
    Ok(match arms {
        [] => None,
        [(op, _, id, invert)] => Some(signed(wires.named(*op, *id)?, *invert)),
        [(op, key, id, invert), rest @ ..] if rest.iter().all(|arm| (&arm.1, arm.3) == (key, *invert)) => {
            Some(signed(wires.shared(*op, *id)?, *invert))
        }
        _ => {
            let mut labelled = Vec::new();
            for (op, _, id, invert) in arms {
                labelled.push((label(&operations[*op]), signed(wires.named(*op, *id)?, *invert)));
            }
            Some(m.case(opcode, &labelled, labelled[0].1))
        }
    })
}

/// The number with its sign inverted.
pub fn negate(number: Wire<'_>) -> Wire<'_> {
    number.builder().concat(&[!number.top(), number.lower(number.width() - 1)])
}

/// Who lives in a number register, in words.
pub fn residents(plan: &Plan, layout: &Layout, place: usize) -> String {
    let named = tenants(plan, layout, place).into_iter().map(|(op, id)| {
        let traced = &plan.operations[op];
        format!("{} {}", traced.name, traced.name_of(id))
    });
    named.collect::<Vec<_>>().join(", ")
}

/// What an operation keeps in the flag register, from bit 0, in words; runs of numbered bits as one.
pub fn flag_residents(plan: &Plan, layout: &Layout, op: usize) -> String {
    let traced = &plan.operations[op];
    let mut words: Vec<String> = Vec::new();
    let mut run: Option<(String, u32, u32)> = None; // stem, first and last number
    for (_, width, id) in flag_fields(layout, op) {
        let name = traced.name_of(id);
        let numbered = name.rsplit_once('_').and_then(|(stem, number)| Some((stem, number.parse::<u32>().ok()?)));
        match (&mut run, numbered) {
            (Some((stem, _, last)), Some((same, number))) if stem == same && *last + 1 == number && width == 1 => {
                *last = number;
                words.pop();
            }
            (_, Some((stem, number))) if width == 1 => run = Some((stem.to_string(), number, number)),
            _ => run = None,
        }
        words.push(match &run {
            Some((stem, first, last)) if first < last => format!("{stem}_{first} to _{last}"),
            _ if width > 1 => format!("{name} ({width} bits)"),
            _ => name,
        });
    }
    if words.is_empty() { "none".to_string() } else { words.join(", ") }
}

/// An operation's fields of the flag register: lowest bit, width and value.
fn flag_fields(layout: &Layout, op: usize) -> Vec<(u32, u32, NodeId)> {
    let mut fields: Vec<(u32, u32, NodeId)> = layout.places[op]
        .iter()
        .filter_map(|(&id, place)| match place {
            Place::Flags { low, width } => Some((*low, *width, id)),
            Place::Number(_) => None,
        })
        .collect();
    fields.sort_unstable();
    fields
}

/// Adds registers, handshake and output ports to a stage. `wires` gives what the stage makes of a value. Returns whether
/// the stage hands on its job in this cycle.
pub fn registers<'m>(
    m: &'m Builder,
    plan: &Plan,
    stage: usize,
    skid: &Arc<Module>,
    opcode: Wire<'m>,
    wires: &mut dyn Wires<'m>,
) -> Result<Handshake<'m>, Error> {
    let layout = &plan.stages[stage].layout;
    m.section("What the job's operation hands on");
    let mut next = vec![("opcode".to_string(), opcode, String::new())];
    for place in 0..layout.numbers {
        let tenants = tenants(plan, layout, place);
        let arms: Vec<_> = tenants.iter().map(|&(op, id)| (op, plan.origin(stage, op, id), id, false)).collect();
        if let Some(wire) = by_opcode(m, opcode, &plan.operations, &arms, wires)? {
            next.push((number(place), wire, residents(plan, layout, place)));
        }
    }
    if let Some(wire) = flags(m, plan, layout, opcode, wires)? {
        next.push(("flags".to_string(), wire, String::new()));
    }

    m.section("Registers: a skid buffer");
    let valid = m.input("valid_i", 1);
    let ready_after = m.input("ready_i", 1);
    let control = m.instance("u_skid", skid, &[("valid_i", valid), ("ready_i", ready_after)]);
    let (ready, valid_out, load_front, load_spare) = (control[0], control[1], control[2], control[3]);
    m.output("ready_o", ready);
    m.output("valid_o", valid_out);
    for (name, wire, residents) in next {
        let bits = wire.width();
        let wire = wire.named(&format!("{name}_d"));
        let spare = m.register(&format!("{name}_spare_q"), bits);
        let front = m.register(&format!("{name}_q"), bits);
        if !residents.is_empty() {
            front.wire().comment(residents);
        }
        spare.next_when(load_spare, wire);
        front.next_when(load_front, ready.mux(wire, spare.wire()));
        m.output(&format!("{name}_o"), front.wire());
    }
    Ok(Handshake { valid, ready })
}

/// A stage's job moves on in a cycle where both are 1.
pub struct Handshake<'m> {
    pub valid: Wire<'m>,
    pub ready: Wire<'m>,
}

/// Who lives in a number register: operations and their values.
pub fn tenants(plan: &Plan, layout: &Layout, place: usize) -> Vec<(usize, NodeId)> {
    let lives =
        |op: usize| layout.places[op].iter().find(|(_, p)| **p == Place::Number(place)).map(|(&id, _)| (op, id));
    (0..plan.operations.len()).filter_map(lives).collect()
}

/// The flag register's next value: for each operation its bits, and zeros where it has none.
fn flags<'m>(
    m: &'m Builder,
    plan: &Plan,
    layout: &Layout,
    opcode: Wire<'m>,
    wires: &mut dyn Wires<'m>,
) -> Result<Option<Wire<'m>>, Error> {
    let mut arms = Vec::new();
    for op in 0..plan.operations.len() {
        let mut parts = Vec::new();
        let mut reached = 0;
        for (low, width, id) in flag_fields(layout, op) {
            if low > reached {
                parts.push(m.constant(low - reached, 0));
            }
            parts.push(wires.named(op, id)?);
            reached = low + width;
        }
        if parts.is_empty() {
            continue;
        }
        if reached < layout.flags {
            parts.push(m.constant(layout.flags - reached, 0));
        }
        parts.reverse();
        arms.push((label(&plan.operations[op]), m.concat(&parts)));
    }
    Ok(match arms.as_slice() {
        [] => None,
        [(_, only)] => Some(*only),
        [(_, first), ..] => Some(m.case(opcode, &arms, *first)),
    })
}
