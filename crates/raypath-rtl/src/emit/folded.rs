//! The registers after a step of a folded pipeline. Each loads in the rounds in which a value comes into it.

use crate::allocate::layout::{FLAG_REGISTER, Layout, RegisterSlot};
use crate::config::Encoding;
use crate::emit::boundary::{self, StepBuilder, Wires, number};
use crate::error::Error;
use crate::fold::{Life, Rounds};
use crate::ir::graph::{NodeId, Op};
use raypath_hdl::{Register, Wire};

/// A value in a register.
#[derive(Clone, Copy)]
struct Resident {
    op: usize,
    id: NodeId,
    life: Life,
}

/// The registers of a boundary under construction.
pub struct Folded<'m, 'p> {
    at: StepBuilder<'m, 'p>,
    rounds: &'p Rounds,
    /// At the input, whether a job enters.
    enters: Option<Wire<'m>>,
}

impl<'m, 'p> Folded<'m, 'p> {
    /// The registers after a step that is not the last. `enters` is given for the input's.
    pub fn new(at: StepBuilder<'m, 'p>, rounds: &'p Rounds, enters: Option<Wire<'m>>) -> Self {
        Self { at, rounds, enters }
    }

    /// Adds the registers and their output ports.
    pub fn store(self, wires: &mut dyn Wires<'m>) -> Result<(), Error> {
        let StepBuilder { m, plan, library, step, opcode, .. } = self.at;
        let layout = &plan.steps[step].layout;
        let name = |slot: RegisterSlot| match slot {
            RegisterSlot::Number(place) => number(place),
            RegisterSlot::Flags { low, .. } => format!("flag_{low}"),
            RegisterSlot::Cut(unit) => unit.stem(),
        };
        for &unit in &layout.cuts {
            m.section(format!("Registers inside {}, which load in every cycle", unit.stem()));
            for (stem, wire) in wires.cut(unit)? {
                let name = format!("{}_{stem}", unit.stem());
                if library.is_inside(unit, &stem) {
                    m.output(&format!("{name}_o"), wire);
                    continue;
                }
                let register = m.register(&format!("{name}_q"), wire.width());
                register.next(wire);
                m.output(&format!("{name}_o"), register.wire());
            }
        }
        m.section("Registers, each with the rounds in which it loads");
        let life = self.rounds.opcode(step + 1);
        let mut stored = vec![("opcode".to_string(), opcode, self.enable(&[Resident { op: 0, id: NodeId(0), life }]))];
        let mut slots: Vec<RegisterSlot> = layout.slots.iter().flat_map(|slots| slots.values().copied()).collect();
        slots.retain(|slot| !matches!(slot, RegisterSlot::Cut(_)));
        slots.sort_unstable();
        slots.dedup();
        for &slot in &slots {
            let residents = self.residents(layout, slot);
            let next = match slot {
                RegisterSlot::Number(_) => self.next_number(&name(slot), &residents, wires)?,
                _ => self.choose(&residents, &mut |op, id| wires.shared(op, id))?,
            };
            if let Some(next) = next {
                stored.push((name(slot), next, self.enable(&residents)));
            }
        }
        let mut registers: Vec<(RegisterSlot, Register<'m>)> = Vec::new();
        for ((name, next, enable), slot) in
            stored.into_iter().zip(std::iter::once(None).chain(slots.into_iter().map(Some)))
        {
            let register = m.register(&format!("{name}_q"), next.width());
            match enable {
                Some(enable) => register.next_when(enable, next),
                None => register.next(next),
            }
            match slot {
                Some(slot) => registers.push((slot, register)),
                None => m.output("opcode_o", register.wire()),
            }
        }
        for (slot, register) in &registers {
            if let RegisterSlot::Number(place) = slot {
                m.output(&format!("{}_o", number(*place)), register.wire());
            }
        }
        for (index, width) in layout.flag_registers().enumerate() {
            let word = self.flag_word(index as u32, width, &registers);
            m.output(&format!("{}_o", boundary::flag_register(layout, index)), word);
        }
        Ok(())
    }

    /// The flag registers of a word, with zeros between them.
    fn flag_word(&self, index: u32, width: u32, registers: &[(RegisterSlot, Register<'m>)]) -> Wire<'m> {
        let m = self.at.m;
        let (mut parts, mut reached) = (Vec::new(), index * FLAG_REGISTER);
        for (slot, register) in registers {
            match *slot {
                RegisterSlot::Flags { low, width } if low / FLAG_REGISTER == index => {
                    if low > reached {
                        parts.push(m.constant(low - reached, 0));
                    }
                    parts.push(register.wire());
                    reached = low + width;
                }
                _ => {}
            }
        }
        if reached < index * FLAG_REGISTER + width {
            parts.push(m.constant(index * FLAG_REGISTER + width - reached, 0));
        }
        parts.reverse();
        m.concat(&parts)
    }

    fn residents(&self, layout: &Layout, slot: RegisterSlot) -> Vec<Resident> {
        let mut residents = Vec::new();
        for (op, slots) in layout.slots.iter().enumerate() {
            let own = slots.iter().filter(|(_, own)| **own == slot);
            residents.extend(own.map(|(&id, _)| Resident { op, id, life: self.rounds.lives[op][self.at.step][&id] }));
        }
        residents
    }

    /// When a register loads; `None` if it may load in every cycle, because each of its values is read in the cycle
    /// after it came and no job waits then.
    fn enable(&self, residents: &[Resident]) -> Option<Wire<'m>> {
        let StepBuilder { positions, .. } = self.at;
        let positions = positions?;
        let stays = |r: &Resident| r.life.length() > 1 || positions.may_wait(r.life.first..=r.life.last);
        if !residents.iter().any(stays) {
            return None;
        }
        if self.enters.is_some() {
            return self.enters;
        }
        let mut loads: Vec<u32> = residents.iter().map(|resident| resident.life.first).collect();
        loads.sort_unstable();
        loads.dedup();
        let loads = loads.into_iter().map(|first| {
            let moves = positions.moves(first - 1);
            let stays = |r: &Resident| r.life.first < first && first <= r.life.last;
            if !residents.iter().any(stays) {
                return moves;
            }
            let mut ops: Vec<usize> = residents.iter().filter(|r| r.life.first == first).map(|r| r.op).collect();
            ops.dedup();
            self.at.is_any(&ops).map_or(moves, |is_own| moves & is_own)
        });
        loads.reduce(|a, b| a | b)
    }

    /// The value that comes into a register in this round.
    fn choose(
        &self,
        residents: &[Resident],
        wire: &mut dyn FnMut(usize, NodeId) -> Result<Wire<'m>, Error>,
    ) -> Result<Option<Wire<'m>>, Error> {
        let origin = |r: &Resident| self.at.plan.origin(self.at.step, r.op, r.id);
        let uses: Vec<_> = residents.iter().map(|r| (r.op, r.life.first.saturating_sub(1), origin(r))).collect();
        self.at.choose(&uses, &mut |index| wire(residents[index].op, residents[index].id))
    }

    /// The next value of a number register, in its encoding, with one encoder or decoder for all rounds.
    fn next_number(
        &self,
        name: &str,
        residents: &[Resident],
        wires: &mut dyn Wires<'m>,
    ) -> Result<Option<Wire<'m>>, Error> {
        let StepBuilder { m, plan, library, step, .. } = self.at;
        let Some(before) = step.checked_sub(1).map(|before| plan.encoding(before)) else {
            return self.choose(residents, &mut |op, id| wires.shared(op, id));
        };
        match (before, plan.encoding(step)) {
            (Encoding::Ieee, Encoding::Recoded) if residents.iter().all(|r| self.is_moved(r.op, r.id)) => {
                let ieee = self.choose(residents, &mut |op, id| self.moved(op, id, wires))?;
                // The step can also read the register of this name before it, through `u_encode_{name}`.
                let name = format!("u_encode_next_{name}");
                Ok(ieee.map(|ieee| m.instance(&name, &library.encode, &[("ieee_i", ieee)])[0]))
            }
            (_, Encoding::Recoded) => self.choose(residents, &mut |op, id| wires.shared(op, id)),
            (before, Encoding::Ieee) => {
                let passes = |r: &Resident| before == Encoding::Ieee && self.is_moved(r.op, r.id);
                let (passing, made): (Vec<Resident>, Vec<Resident>) = residents.iter().partition(|r| passes(r));
                let recoded = self.choose(&made, &mut |op, id| wires.shared(op, id))?;
                let name = format!("u_decode_{name}");
                let decoded = recoded.map(|wire| m.instance(&name, &library.decode, &[("recoded_i", wire)])[0]);
                let uses: Vec<_> = (residents.iter())
                    .map(|r| {
                        let origin = passes(r).then(|| plan.origin(step, r.op, r.id));
                        (r.op, r.life.first - 1, origin)
                    })
                    .collect();
                debug_assert!(passing.len() + made.len() == residents.len());
                self.at.choose(&uses, &mut |index| match (&uses[index].2, decoded) {
                    (None, Some(decoded)) => Ok(decoded),
                    _ => self.moved(residents[index].op, residents[index].id, wires),
                })
            }
        }
    }

    /// Whether a number is only selected from registers, so that it needs no unit's encoding.
    fn is_moved(&self, op: usize, id: NodeId) -> bool {
        let StepBuilder { plan, step, .. } = self.at;
        if matches!(plan.steps[step - 1].layout.slot(op, id), Some(RegisterSlot::Number(_))) {
            return true;
        }
        let is_word = plan.steps[step - 1].layout.slot(op, id).is_some();
        match plan.operations[op].node(id).op {
            Op::Select(_, a, b) if !is_word => self.is_moved(op, a) && self.is_moved(op, b),
            _ => false,
        }
    }

    /// A moved number in the encoding of the registers before.
    fn moved(&self, op: usize, id: NodeId, wires: &mut dyn Wires<'m>) -> Result<Wire<'m>, Error> {
        let StepBuilder { plan, step, .. } = self.at;
        match plan.operations[op].node(id).op {
            Op::Select(condition, a, b) if plan.steps[step - 1].layout.slot(op, id).is_none() => {
                let condition = wires.named(op, condition)?;
                Ok(condition.mux(self.moved(op, a, wires)?, self.moved(op, b, wires)?))
            }
            _ => wires.register(op, id),
        }
    }
}
