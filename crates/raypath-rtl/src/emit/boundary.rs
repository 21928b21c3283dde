//! The next values of the registers after a step, selected by opcode.

use crate::allocate::layout::{FLAG_REGISTER, Layout, Origin, RegisterSlot};
use crate::allocate::plan::Plan;
use crate::config::{Encoding, Sharing};
use crate::emit::library::Library;
use crate::emit::positions::Positions;
use crate::error::Error;
use crate::ir::graph::{NodeId, OperationGraph};
use crate::ir::position::Step;
use crate::ir::units::Unit;
use raypath_hdl::{Builder, Label, Wire};
use std::collections::BTreeSet;

/// The name of a number register at a port.
pub fn number(place: usize) -> String {
    format!("num_{place}")
}

/// The name of a flag register at a port.
pub fn flag_register(layout: &Layout, register: usize) -> String {
    if layout.flags <= FLAG_REGISTER { "flags".to_string() } else { format!("flags_{register}") }
}

/// The label of an operation's opcode: `OpQuadbox`.
pub fn label(traced: &OperationGraph<Step>) -> Label {
    let mut name = String::from("Op");
    for word in traced.name.split('_') {
        let (first, rest) = word.split_at(word.len().min(1));
        name.push_str(&first.to_uppercase());
        name.push_str(rest);
    }
    Label { name, value: traced.opcode }
}

/// The wires of an operation's values in a step. Numbers are recoded.
pub trait Wires<'m> {
    /// The wire, under the value's name.
    fn named(&mut self, op: usize, id: NodeId) -> Result<Wire<'m>, Error>;
    /// The same net without that name: operations that share it have different names for it.
    fn shared(&mut self, op: usize, id: NodeId) -> Result<Wire<'m>, Error> {
        self.named(op, id)
    }
    /// A register before the step, in its encoding there.
    fn register(&mut self, op: usize, id: NodeId) -> Result<Wire<'m>, Error> {
        self.named(op, id)
    }
    /// The results of a unit's part for its next part, with the stems of the ports.
    fn cut(&mut self, unit: Unit) -> Result<Vec<(String, Wire<'m>)>, Error>;
}

/// An arm of a choice by opcode: the operation, a key that identifies the net, the value, and whether to invert its
/// sign.
pub type Arm<K> = (usize, K, NodeId, bool);

/// The number with its sign inverted.
pub fn negate(number: Wire<'_>) -> Wire<'_> {
    number.builder().concat(&[!number.top(), number.lower(number.width() - 1)])
}

/// The names of the values that share a number register.
pub fn live_value_names(plan: &Plan, layout: &Layout, place: usize) -> String {
    let named = live_values(plan, layout, place).into_iter().map(|(op, id)| {
        let traced = &plan.operations[op];
        format!("{} {}", traced.name, traced.name_of(id))
    });
    named.collect::<Vec<_>>().join(", ")
}

/// The names of an operation's values in the flag registers, from bit 0; a run of numbered bits is one entry.
pub fn live_flag_names(plan: &Plan, layout: &Layout, op: usize) -> String {
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
    let mut fields: Vec<(u32, u32, NodeId)> = layout.slots[op]
        .iter()
        .filter_map(|(&id, place)| match place {
            RegisterSlot::Flags { low, width } => Some((*low, *width, id)),
            RegisterSlot::Number(_) | RegisterSlot::Cut(_) => None,
        })
        .collect();
    fields.sort_unstable();
    fields
}

/// The next value of a register.
pub struct Next<'m> {
    /// The register's name without `_q`.
    pub name: String,
    pub wire: Wire<'m>,
    /// The operations that have a value in the register.
    pub users: BTreeSet<usize>,
    /// The register is inside a unit's part before or after the boundary, which has wires.
    pub is_inside: bool,
}

impl<'m> Next<'m> {
    fn new(name: String, wire: Wire<'m>, users: BTreeSet<usize>) -> Self {
        Self { name, wire, users, is_inside: false }
    }
}

/// A step under construction.
#[derive(Clone, Copy)]
pub struct StepBuilder<'m, 'p> {
    /// The builder of its module.
    pub m: &'m Builder,
    pub plan: &'p Plan,
    pub library: &'p Library,
    /// Its index in the plan.
    pub step: usize,
    /// The opcode of the job in the registers before it.
    pub opcode: Wire<'m>,
    /// Where the job is, in a folded pipeline.
    pub positions: Option<&'p Positions<'m>>,
}

impl<'m> StepBuilder<'m, '_> {
    /// Whether the job belongs to one of these operations; `None` if there is none.
    pub fn is_any(self, ops: &[usize]) -> Option<Wire<'m>> {
        let is = |&op: &usize| {
            let label = self.m.label(&self.label(op), self.opcode.width());
            self.opcode.equals(label)
        };
        ops.iter().map(is).reduce(|a, b| a | b)
    }

    /// The net that the job's operation uses at its position, in a folded pipeline. A use is an operation, a position
    /// and a key that identifies the net; `wire` gives the net of the use with an index. No multiplexer if all are the
    /// same net. Without a use for the job, any net.
    pub fn choose<K: PartialEq>(
        self,
        uses: &[(usize, u32, K)],
        wire: &mut dyn FnMut(usize) -> Result<Wire<'m>, Error>,
    ) -> Result<Option<Wire<'m>>, Error> {
        // The uses of each net.
        let mut nets: Vec<Vec<usize>> = Vec::new();
        for (index, (_, _, key)) in uses.iter().enumerate() {
            match nets.iter_mut().find(|net| uses[net[0]].2 == *key) {
                Some(net) => net.push(index),
                None => nets.push(vec![index]),
            }
        }
        let has = |net: &[usize], op: usize, position: Option<u32>| {
            net.iter().any(|&index| uses[index].0 == op && position.is_none_or(|position| uses[index].1 == position))
        };
        let ops = |net: &[usize], position: Option<u32>| -> Vec<usize> {
            (0..self.plan.operations.len()).filter(|&op| has(net, op, position)).collect()
        };
        let all: Vec<usize> = (0..uses.len()).collect();
        let is_by_opcode = ops(&all, None).iter().all(|&op| nets.iter().filter(|net| has(net, op, None)).count() == 1);
        // The condition for a net: terms of a position and operations.
        let terms = |net: &Vec<usize>| -> Vec<(Option<u32>, Vec<usize>)> {
            if is_by_opcode {
                return vec![(None, ops(net, None))];
            }
            let mut positions: Vec<u32> = net.iter().map(|&index| uses[index].1).collect();
            positions.sort_unstable();
            positions.dedup();
            let term = |position| {
                let own = ops(net, Some(position));
                let is_only = own == ops(&all, Some(position));
                (Some(position), if is_only { Vec::new() } else { own })
            };
            positions.into_iter().map(term).collect()
        };
        // The net with the longest condition needs none.
        let Some(rest) = (0..nets.len()).max_by_key(|&net| terms(&nets[net]).len()) else { return Ok(None) };
        let mut chosen = wire(nets[rest][0])?;
        for (_, net) in nets.iter().enumerate().filter(|(number, _)| *number != rest) {
            let condition = terms(net).into_iter().filter_map(|(position, ops)| {
                let at = position.and_then(|position| Some(self.positions?.at(position)));
                match (at, self.is_any(&ops)) {
                    (Some(at), Some(is)) => Some(at & is),
                    (at, is) => at.or(is),
                }
            });
            if let Some(condition) = condition.reduce(|a, b| a | b) {
                chosen = condition.mux(wire(net[0])?, chosen);
            }
        }
        Ok(Some(chosen))
    }

    /// The operand of a unit in each round: [`Self::by_opcode`] with the positions of the arms.
    pub fn by_round<K: PartialEq>(
        self,
        arms: &[(u32, Arm<K>)],
        wires: &mut dyn Wires<'m>,
    ) -> Result<Option<Wire<'m>>, Error> {
        let uses: Vec<_> =
            arms.iter().map(|(position, (op, key, _, invert))| (*op, *position, (key, *invert))).collect();
        self.choose(&uses, &mut |index| {
            let (_, (op, _, id, invert)) = &arms[index];
            let wire = wires.shared(*op, *id)?;
            Ok(if *invert { negate(wire) } else { wire })
        })
    }

    /// The value of the job's operation among `arms`, without a multiplexer if all are the same net. An opcode without
    /// an operation selects the first arm.
    pub fn by_opcode<K: PartialEq>(
        self,
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
                    labelled.push((self.label(*op), signed(wires.named(*op, *id)?, *invert)));
                }
                Some(self.m.case(self.opcode, &labelled, labelled[0].1))
            }
        })
    }

    /// The next values of the registers after the step.
    pub fn next(self, wires: &mut dyn Wires<'m>) -> Result<Vec<Next<'m>>, Error> {
        let layout = &self.plan.steps[self.step].layout;
        self.m.section("Next values of the registers");
        let operations = 0..self.plan.operations.len();
        let mut next = vec![Next::new("opcode".to_string(), self.opcode, operations.clone().collect())];
        for place in 0..layout.numbers {
            if let Some(wire) = self.next_number(place, wires)? {
                let users = live_values(self.plan, layout, place).into_iter().map(|(op, _)| op).collect();
                next.push(Next::new(number(place), wire, users));
            }
        }
        for &unit in &layout.cuts {
            let is_user = |op: &usize| layout.slots[*op].values().any(|slot| *slot == RegisterSlot::Cut(unit));
            let users: BTreeSet<usize> = operations.clone().filter(is_user).collect();
            for (stem, wire) in wires.cut(unit)? {
                let is_inside = self.library.is_inside(unit, &stem);
                let name = format!("{}_{stem}", unit.stem());
                next.push(Next { is_inside, ..Next::new(name, wire, users.clone()) });
            }
        }
        for (register, width) in layout.flag_registers().enumerate() {
            if let Some(wire) = self.next_flags(register, width, wires)? {
                let is_here = |(low, ..): &(u32, u32, NodeId)| *low / FLAG_REGISTER == register as u32;
                let is_user = |op: &usize| flag_fields(layout, *op).iter().any(is_here);
                let users = operations.clone().filter(is_user).collect();
                next.push(Next::new(flag_register(layout, register), wire, users));
            }
        }
        Ok(next)
    }

    /// The next value of a number register, in its encoding. Values that pass in the same encoding are unchanged.
    /// Others are decoded after the choice by opcode, so one decoder for each register is enough.
    fn next_number(self, place: usize, wires: &mut dyn Wires<'m>) -> Result<Option<Wire<'m>>, Error> {
        let Self { m, plan, library, step, .. } = self;
        let live_values = live_values(plan, &plan.steps[step].layout, place);
        let arms: Vec<_> = live_values.iter().map(|&(op, id)| (op, plan.origin(step, op, id), id, false)).collect();
        let before = step.checked_sub(1).map(|before| plan.encoding(before));
        let decodes = plan.encoding(step) == Encoding::Ieee && before.is_some();
        if !decodes {
            return self.by_opcode(&arms, wires);
        }
        let passes = |origin: &Origin| before == Some(Encoding::Ieee) && matches!(origin, Origin::Register(_));
        let (passing, made): (Vec<_>, Vec<_>) = arms.into_iter().partition(|(_, origin, ..)| passes(origin));
        let short = library.decode_narrow().filter(|_| made.iter().all(|&(op, _, id, _)| plan.widths.is_short(op, id)));
        let decoded = self.by_opcode(&made, wires)?.map(|wire| {
            let name = format!("u_decode_{}", number(place));
            let Some(short) = short else { return m.instance(&name, &library.decode, &[("recoded_i", wire)])[0] };
            let width = short.signal(short.inputs()[0].signal).width;
            let missing = wire.width() - width;
            m.unused(&format!("unused_decode_{}", number(place)), &[wire.lower(missing)]);
            let decoded = m.instance(&name, short, &[("recoded_i", wire.upper(width))])[0];
            m.concat(&[decoded, m.constant(missing, 0)])
        });
        let Some(decoded) = decoded else { return self.by_opcode(&passing, &mut Registers(wires)) };
        if passing.is_empty() {
            return Ok(Some(decoded));
        }
        let mut labelled = Vec::new();
        for &(op, _, id, _) in &passing {
            labelled.push((self.label(op), wires.register(op, id)?));
        }
        Ok(Some(m.case(self.opcode, &labelled, decoded)))
    }

    /// The next value of a flag register: the bits of each operation, and zeros between them.
    fn next_flags(self, register: usize, width: u32, wires: &mut dyn Wires<'m>) -> Result<Option<Wire<'m>>, Error> {
        let Self { m, plan, .. } = self;
        let layout = &plan.steps[self.step].layout;
        let first = register as u32 * FLAG_REGISTER;
        let own = |op: usize| {
            flag_fields(layout, op).into_iter().filter(move |field| field.0 / FLAG_REGISTER == first / FLAG_REGISTER)
        };
        if plan.microarchitecture.sharing == Sharing::Segregated {
            let mut fields: Vec<_> = (0..plan.operations.len()).flat_map(|op| own(op).map(move |f| (op, f))).collect();
            fields.sort_unstable_by_key(|(_, field)| field.0);
            return flag_word(m, first, width, fields.into_iter(), wires);
        }
        let mut arms = Vec::new();
        for op in 0..plan.operations.len() {
            if let Some(word) = flag_word(m, first, width, own(op).map(|field| (op, field)), wires)? {
                arms.push((self.label(op), word));
            }
        }
        Ok(match arms.as_slice() {
            [] => None,
            [(_, only)] => Some(*only),
            [(_, first), ..] => Some(m.case(self.opcode, &arms, *first)),
        })
    }

    fn label(self, op: usize) -> Label {
        label(&self.plan.operations[op])
    }
}

/// The values in the registers before the step, in their encoding.
struct Registers<'w, 'm>(&'w mut dyn Wires<'m>);

impl<'m> Wires<'m> for Registers<'_, 'm> {
    fn named(&mut self, op: usize, id: NodeId) -> Result<Wire<'m>, Error> {
        self.0.register(op, id)
    }
    fn cut(&mut self, unit: Unit) -> Result<Vec<(String, Wire<'m>)>, Error> {
        self.0.cut(unit)
    }
}

/// The operations that use a number register, and their values in it: one each, or in a folded pipeline several.
fn live_values(plan: &Plan, layout: &Layout, place: usize) -> Vec<(usize, NodeId)> {
    let values = |op: usize| {
        let own = layout.slots[op].iter().filter(move |(_, slot)| **slot == RegisterSlot::Number(place));
        own.map(move |(&id, _)| (op, id))
    };
    (0..plan.operations.len()).flat_map(values).collect()
}

/// Fields, lowest first, as one word of `width` bits that begins at flag bit `first`; `None` if there are no fields.
fn flag_word<'m>(
    m: &'m Builder,
    first: u32,
    width: u32,
    fields: impl Iterator<Item = (usize, (u32, u32, NodeId))>,
    wires: &mut dyn Wires<'m>,
) -> Result<Option<Wire<'m>>, Error> {
    let mut parts = Vec::new();
    let mut reached = first;
    for (op, (low, bits, id)) in fields {
        if low > reached {
            parts.push(m.constant(low - reached, 0));
        }
        parts.push(wires.named(op, id)?);
        reached = low + bits;
    }
    if parts.is_empty() {
        return Ok(None);
    }
    if reached < first + width {
        parts.push(m.constant(first + width - reached, 0));
    }
    parts.reverse();
    Ok(Some(m.concat(&parts)))
}
