//! The values of one step as wires: from the registers before it, from its units, and from the operations' logic.

use crate::allocate::layout::{FLAG_REGISTER, Origin, RegisterSlot};
use crate::allocate::plan::Plan;
use crate::config::Encoding;
use crate::emit::boundary::{self, StepBuilder, Wires, negate};
use crate::emit::isolation;
use crate::emit::library::Library;
use crate::error::Error;
use crate::ir::graph::{Kind, NodeId, Op};
use crate::ir::units::{Unit, UnitWidth};
use raypath_float::Format;
use raypath_hdl::{Builder, Wire};
use raypath_ops::{Relation, Test};
use std::collections::{BTreeMap, BTreeSet};

/// The wires of a step's values, built on demand.
pub struct Values<'m, 'p> {
    at: StepBuilder<'m, 'p>,
    inputs: StepInputs<'m>,
    made: BTreeMap<(usize, NodeId), Wire<'m>>,
    /// Number registers, recoded.
    recoded: BTreeMap<usize, Wire<'m>>,
    units: BTreeMap<Unit, Vec<Wire<'m>>>,
    in_progress: BTreeSet<Unit>,
    /// Whether the job belongs to one of these operations.
    computes: BTreeMap<Vec<usize>, Wire<'m>>,
    names: BTreeSet<String>,
}

/// The inputs of a step.
pub struct StepInputs<'m> {
    /// The encoding of the numbers.
    pub encoding: Encoding,
    /// Number registers before the step.
    pub numbers: Vec<Wire<'m>>,
    /// The flag registers before the step.
    pub flags: Vec<Wire<'m>>,
    /// The intermediate results of units for their next parts, with the stems of their ports.
    pub cuts: BTreeMap<Unit, Vec<(String, Wire<'m>)>>,
    /// State that the step reads, by operation and number.
    pub states: BTreeMap<(usize, usize), Wire<'m>>,
}

impl<'m> StepInputs<'m> {
    /// The registers before a step as input ports.
    pub fn ports(m: &'m Builder, plan: &Plan, library: &Library, step: usize) -> Self {
        let layout = &plan.steps[step - 1].layout;
        let width = plan.number_width(step - 1);
        let number = |index| m.input(&format!("{}_i", boundary::number(index)), width);
        let numbers = (0..layout.numbers).map(number).collect();
        let cut = |unit: Unit| {
            let port = |(stem, width)| (String::from(stem), m.input(&format!("{}_{stem}_i", unit.stem()), width));
            (unit, library.cut(unit).map(port).collect())
        };
        let cuts = layout.cuts.iter().copied().map(cut).collect();
        let flag = |(register, width)| m.input(&format!("{}_i", boundary::flag_register(layout, register)), width);
        let flags = layout.flag_registers().enumerate().map(flag).collect();
        Self { encoding: plan.encoding(step - 1), numbers, flags, cuts, states: BTreeMap::new() }
    }

    /// The contents of a slot in their encoding there; `None` for a cut.
    pub fn read(&self, slot: RegisterSlot) -> Option<Wire<'m>> {
        match slot {
            RegisterSlot::Number(register) => self.numbers.get(register).copied(),
            RegisterSlot::Flags { low, width } => {
                let register = self.flags.get((low / FLAG_REGISTER) as usize)?;
                let low = low % FLAG_REGISTER;
                Some(register.bits(low + width - 1, low))
            }
            RegisterSlot::Cut(_) => None,
        }
    }
}

impl<'m, 'p> Values<'m, 'p> {
    /// The values of a step with these inputs.
    pub fn new(at: StepBuilder<'m, 'p>, inputs: StepInputs<'m>) -> Self {
        Self {
            at,
            inputs,
            made: BTreeMap::new(),
            recoded: BTreeMap::new(),
            units: BTreeMap::new(),
            in_progress: BTreeSet::new(),
            computes: BTreeMap::new(),
            names: BTreeSet::new(),
        }
    }

    /// The values read from the registers before the step, in order.
    pub fn read_from_registers(&self) -> Vec<(usize, NodeId)> {
        self.made.keys().copied().filter(|&(op, id)| self.slot(op, id).is_some()).collect()
    }

    /// The wire of an operation's value, named as in the operation's description.
    pub fn get(&mut self, op: usize, id: NodeId) -> Result<Wire<'m>, Error> {
        let id = self.first_alike(op, id);
        if let Some(&wire) = self.made.get(&(op, id)) {
            return Ok(wire);
        }
        let wire = self.make(op, id)?;
        let graph = &self.at.plan.operations[op];
        let wire = match &graph.node(id).name {
            Some(name) if !graph.is_everywhere(id) => {
                let repeats = name.strip_prefix(graph.name).is_some_and(|rest| rest.starts_with('_'));
                let full = if repeats { name.clone() } else { format!("{}_{name}", graph.name) };
                let name = self.free_name(&full);
                wire.named(&name)
            }
            _ => wire,
        };
        self.made.insert((op, id), wire);
        Ok(wire)
    }

    /// The first of the values that are the same net in a folded pipeline.
    fn first_alike(&self, op: usize, id: NodeId) -> NodeId {
        let alike = self.at.plan.steps[self.at.step].alike.get(op);
        let first = alike.and_then(|alike| alike.get(&id).copied());
        if self.slot(op, id).is_some() { id } else { first.unwrap_or(id) }
    }

    /// A unit's results, in the order of its ports.
    pub fn unit(&mut self, unit: Unit) -> Result<Vec<Wire<'m>>, Error> {
        if let Some(wires) = self.units.get(&unit) {
            return Ok(wires.clone());
        }
        if !self.in_progress.insert(unit) {
            return Err(Error::UnitLoop { stage: self.at.plan.steps[self.at.step].label.stage });
        }
        let residue = self.at.library.residue.as_ref().filter(|_| self.at.plan.has_residue(self.at.step, unit));
        let module = residue.unwrap_or_else(|| self.at.library.unit(unit));
        let mut connections = Vec::new();
        for (operand, port) in module.inputs().iter().enumerate() {
            let wire = if unit.part == 0 {
                let number = self.operand(unit, operand, &format!("{}_{}", unit.stem(), port.stem()))?;
                self.shortened(number, module.signal(port.signal).width, &format!("{}_{}", unit.stem(), port.stem()))
            } else {
                self.result_of_part_before(unit, port.stem())?
            };
            connections.push((port.name.as_str(), wire));
        }
        let mut wires = self.at.m.instance(&format!("u_{}", unit.stem()), module, &connections);
        if matches!(unit.width, UnitWidth::Rounding(_)) && module.outputs().len() == 1 {
            wires = vec![self.padded(wires[0])];
        }
        self.units.insert(unit, wires.clone());
        Ok(wires)
    }

    /// The upper bits of a number, as a unit reads them. The others are zeros in a number with a short significand.
    fn shortened(&self, number: Wire<'m>, width: u32, reader: &str) -> Wire<'m> {
        if number.width() == width {
            return number;
        }
        self.at.m.unused(&format!("unused_{reader}"), &[number.lower(number.width() - width)]);
        number.upper(width)
    }

    /// A number with a short significand as one of the format.
    fn padded(&self, number: Wire<'m>) -> Wire<'m> {
        let missing = self.at.library.format.recoded_width() - number.width();
        if missing == 0 { number } else { self.at.m.concat(&[number, self.at.m.constant(missing, 0)]) }
    }

    /// The intermediate result of the part before, whose unit has the same number.
    fn result_of_part_before(&self, unit: Unit, stem: &str) -> Result<Wire<'m>, Error> {
        let cut = self.inputs.cuts.get(&Unit { part: unit.part - 1, ..unit }).into_iter().flatten();
        let found = cut.into_iter().find(|(port, _)| port == stem).map(|(_, wire)| *wire);
        let missing =
            || Error::PartApart { unit: unit.stem(), step: self.at.plan.steps[self.at.step].label.to_string() };
        found.ok_or_else(missing)
    }

    /// One operand of a unit, selected by opcode. A difference is a sum with the sign of the second operand inverted.
    fn operand(&mut self, unit: Unit, operand: usize, name: &str) -> Result<Wire<'m>, Error> {
        let users: Vec<(usize, NodeId)> = self.at.plan.users(self.at.step, unit);
        let inverted =
            |op: usize, id: NodeId| operand == 1 && matches!(self.at.plan.operations[op].node(id).op, Op::Subtract(..));
        let all_inverted = users.iter().all(|&(op, id)| inverted(op, id));
        let arms: Vec<_> = users
            .into_iter()
            .map(|(op, id)| {
                let swapped = self.at.plan.steps[self.at.step].bindings[op][&id].swapped;
                let source = self.at.plan.operations[op].operands(id)[if swapped { 1 - operand } else { operand }];
                (op, self.at.plan.origin(self.at.step, op, source), source, inverted(op, id) && !all_inverted)
            })
            .collect();
        let StepBuilder { m, plan, library, step, .. } = self.at;
        let chosen = match &plan.rounds {
            None => self.at.by_opcode(&arms, self)?,
            Some(rounds) => {
                let arms = arms.iter().zip(self.at.plan.users(self.at.step, unit)).map(
                    |((op, origin, source, inverts), (_, id))| {
                        (rounds.units[*op][step][&id], (*op, origin, *source, *inverts))
                    },
                );
                self.at.by_round(&arms.collect::<Vec<_>>(), self)?
            }
        };
        let chosen = chosen.unwrap_or_else(|| m.constant(library.format.recoded_width(), 0));
        let one_net = arms.iter().all(|arm| (&arm.1, arm.3) == (&arms[0].1, arms[0].3));
        let mut chosen = if one_net { chosen } else { chosen.named(name) };
        if let Some(computes) = self.isolation(unit) {
            chosen = (chosen & computes.replicate(chosen.width())).named(&format!("{name}_or_zero"));
        }
        Ok(if all_inverted { negate(chosen) } else { chosen })
    }

    /// Whether the job uses a unit, if the unit needs [isolation](isolation) from other jobs.
    fn isolation(&mut self, unit: Unit) -> Option<Wire<'m>> {
        let users = isolation::users_to_isolate(self.at.plan, self.at.step, unit)?;
        if let Some(&computes) = self.computes.get(&users) {
            return Some(computes);
        }
        let names: Vec<&str> = users.iter().map(|&op| self.at.plan.operations[op].name).collect();
        let name = self.free_name(&format!("computes_{}", names.join("_")));
        let computes = self.at.is_any(&users)?.named(&name);
        self.computes.insert(users, computes);
        Some(computes)
    }

    fn make(&mut self, op: usize, id: NodeId) -> Result<Wire<'m>, Error> {
        let m = self.at.m;
        if let Some(slot) = self.slot(op, id) {
            return self.read(op, id, slot);
        }
        let graph = &self.at.plan.operations[op];
        let node = graph.node(id);
        Ok(match node.op {
            Op::Input(_) => return Err(self.unplaced(op, id)),
            Op::State(state) => *self.inputs.states.get(&(op, state)).ok_or_else(|| self.unplaced(op, id))?,
            Op::Number(bits) => {
                let format = self.at.library.format;
                m.constant(format.recoded_width(), format.encode(format.from_f32(f32::from_bits(bits))))
            }
            Op::Ulps(ulps) => {
                let format = self.at.library.format;
                m.constant(format.recoded_width(), format.encode(format.ulps(ulps)))
            }
            Op::Bit(value) => m.constant(1, value.into()),
            Op::Word(value) => {
                let Kind::Word(width) = node.kind else { unreachable!("a word constant has a word's kind") };
                m.constant(width, value.into())
            }
            Op::Continue(_) | Op::Add(..) | Op::Sum(_) | Op::Subtract(..) | Op::Multiply(..) | Op::Compare(..) => {
                let unit = self.at.plan.steps[self.at.step].bindings[op][&id].unit;
                self.unit(unit)?[0]
            }
            Op::Relation(order, relation) => {
                let unit = self.at.plan.steps[self.at.step].bindings[op][&order].unit;
                let results = self.unit(unit)?;
                relate(results[0], results[1], results[2], relation)
            }
            Op::Flags(a) | Op::Residue(a, ..) => {
                let unit = self.at.plan.steps[self.at.step].bindings[op][&a].unit;
                self.unit(unit)?[1]
            }
            Op::Negate(a) => negate(self.get(op, a)?),
            Op::Narrow(a, to) => {
                let number = self.get(op, a)?;
                let rounds = UnitWidth::Rounding(to);
                if self.at.plan.steps[self.at.step].bindings[op].get(&a).is_some_and(|b| b.unit.width == rounds) {
                    return Ok(number);
                }
                let name = self.free_name(&format!("u_narrow_{}_{}", graph.name, graph.name_of(id)));
                let unit = self.at.library.narrowing(to).ok_or_else(|| self.unplaced(op, a))?;
                self.padded(m.instance(&name, unit, &[("number_i", number)])[0])
            }
            Op::NumberOf(a) => {
                let word = self.get(op, a)?;
                let name = self.free_name(&format!("u_number_{}_{}", graph.name, graph.name_of(id)));
                let unit = self.at.library.number(word.width()).ok_or_else(|| self.unplaced(op, a))?;
                m.instance(&name, unit, &[("word_i", word)])[0]
            }
            Op::Test(test, a) => self.test(test, op, a)?,
            Op::And(a, b) => self.get(op, a)? & self.get(op, b)?,
            Op::Or(a, b) | Op::WordOr(a, b) => self.get(op, a)? | self.get(op, b)?,
            Op::Not(a) => !self.get(op, a)?,
            Op::WordEqual(a, b) => self.get(op, a)?.equals(self.get(op, b)?),
            Op::WordLess(a, b) => self.get(op, a)?.less(self.get(op, b)?),
            Op::Select(condition, a, b) => {
                let condition = self.get(op, condition)?;
                condition.mux(self.get(op, a)?, self.get(op, b)?)
            }
        })
    }

    fn slot(&self, op: usize, id: NodeId) -> Option<RegisterSlot> {
        self.at.plan.steps[self.at.step.checked_sub(1)?].layout.slot(op, id)
    }

    /// The contents of a slot; a number is recoded.
    fn read(&mut self, op: usize, id: NodeId, slot: RegisterSlot) -> Result<Wire<'m>, Error> {
        let wire = self.inputs.read(slot).ok_or_else(|| self.unplaced(op, id))?;
        let RegisterSlot::Number(register) = slot else { return Ok(wire) };
        if self.inputs.encoding == Encoding::Recoded {
            return Ok(wire);
        }
        let (m, library) = (self.at.m, self.at.library);
        let name = format!("u_encode_{}", boundary::number(register));
        let encode = || m.instance(&name, &library.encode, &[("ieee_i", wire)])[0];
        Ok(*self.recoded.entry(register).or_insert_with(encode))
    }

    /// A test of a number, in the encoding of its register, so that it needs no encoder.
    fn test(&mut self, test: Test, op: usize, a: NodeId) -> Result<Wire<'m>, Error> {
        match (self.slot(op, a), self.inputs.encoding) {
            (Some(slot @ RegisterSlot::Number(_)), Encoding::Ieee) => {
                let number = self.inputs.read(slot).ok_or_else(|| self.unplaced(op, a))?;
                Ok(test_ieee(test, number, self.at.library.format))
            }
            // The test reads four bits only, so the number is not named for it.
            _ => Ok(test_class(test, self.shared(op, a)?)),
        }
    }

    fn unplaced(&self, op: usize, id: NodeId) -> Error {
        self.at.plan.operations[op].unplaced(id)
    }

    fn free_name(&mut self, wanted: &str) -> String {
        let candidates = std::iter::once(wanted.to_string()).chain((2..).map(|n| format!("{wanted}_v{n}")));
        let mut free = candidates.skip_while(|name| self.names.contains(name));
        let name = free.next().unwrap_or_default();
        self.names.insert(name.clone());
        name
    }
}

impl<'m> Wires<'m> for Values<'m, '_> {
    fn named(&mut self, op: usize, id: NodeId) -> Result<Wire<'m>, Error> {
        self.get(op, id)
    }

    fn shared(&mut self, op: usize, id: NodeId) -> Result<Wire<'m>, Error> {
        match self.at.plan.origin(self.at.step, op, id) {
            Origin::Register(slot) => self.read(op, id, slot),
            Origin::Unit(unit) => Ok(self.unit(unit)?[0]),
            Origin::Port(_) | Origin::Logic(..) => self.get(op, id),
        }
    }

    fn register(&mut self, op: usize, id: NodeId) -> Result<Wire<'m>, Error> {
        self.slot(op, id).and_then(|slot| self.inputs.read(slot)).ok_or_else(|| self.unplaced(op, id))
    }

    fn cut(&mut self, unit: Unit) -> Result<Vec<(String, Wire<'m>)>, Error> {
        let stems: Vec<String> = self.at.library.cut(unit).map(|(stem, _)| stem.to_string()).collect();
        Ok(stems.into_iter().zip(self.unit(unit)?).collect())
    }
}

fn relate<'m>(less: Wire<'m>, equal: Wire<'m>, unordered: Wire<'m>, relation: Relation) -> Wire<'m> {
    match relation {
        Relation::Less => less,
        Relation::LessOrEqual => less | equal,
        Relation::Equal => equal,
        Relation::GreaterOrEqual => !(less | unordered),
        Relation::Greater => !(less | equal | unordered),
    }
}

/// A test of a number in the IEEE 754 layout.
fn test_ieee<'m>(test: Test, a: Wire<'m>, format: Format) -> Wire<'m> {
    let sign = a.top();
    let zero = || !a.lower(a.width() - 1).any();
    let fraction_width = format.significand() - 1;
    let nan = || a.bits(a.width() - 2, fraction_width).all() & a.lower(fraction_width).any();
    match test {
        Test::SignBit => sign,
        Test::Zero => zero(),
        Test::Nan => nan(),
        Test::AtLeastZero => (!sign & !nan()) | zero(),
        Test::AboveZero => !sign & !nan() & !zero(),
        Test::AtMostZero => (sign & !nan()) | zero(),
        Test::BelowZero => sign & !nan() & !zero(),
    }
}

/// A test of a recoded number: the sign bit and the top three bits of the exponent
/// (`docs/reference/formats.md`).
fn test_class(test: Test, a: Wire<'_>) -> Wire<'_> {
    let sign = a.top();
    let class = a.bits(a.width() - 2, a.width() - 4);
    match test {
        Test::SignBit => sign,
        Test::Zero => class.is(0b000),
        Test::Nan => class.is(0b111),
        Test::AtLeastZero => (!sign & !class.is(0b111)) | class.is(0b000),
        Test::AboveZero => !sign & !class.is(0b111) & !class.is(0b000),
        Test::AtMostZero => (sign & !class.is(0b111)) | class.is(0b000),
        Test::BelowZero => sign & !class.is(0b111) & !class.is(0b000),
    }
}
