//! The registers after a step: a skid buffer, a register that never stalls, or the FIFO at the exit.

use crate::allocate::delays::Delay;
use crate::emit::boundary::{Next, StepBuilder, label, number};
use crate::emit::control::{Exit, Gate, Plain, Skid};
use crate::emit::interface;
use crate::error::Error;
use raypath_hdl::text::PortGroup;
use raypath_hdl::{Builder, Module, Register, Wire};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The most jobs behind the one that the sink sees that wait in registers.
const MOST_REGISTERS: u32 = 32;

/// The registers after a step.
pub struct Registers<'m, 'p> {
    at: StepBuilder<'m, 'p>,
    /// The output port that shows them.
    output: PortGroup,
    next: Vec<Next<'m>>,
}

impl<'m, 'p> Registers<'m, 'p> {
    /// The registers after a step of a plan, which take `next`.
    pub fn new(at: StepBuilder<'m, 'p>, mut next: Vec<Next<'m>>) -> Self {
        let StepBuilder { plan, library, step, .. } = at;
        let output = interface::output(plan, library, step);
        next.iter_mut().for_each(|next| next.wire = next.wire.named(&format!("{}_d", next.name)));
        Self { at, output, next }
    }

    /// Adds skid buffers, their handshake and output ports. `hold` keeps the job in the registers before. Returns
    /// whether the job leaves the step in this cycle.
    pub fn skid_buffers(self, hold: Option<Wire<'m>>) -> Wire<'m> {
        let (m, library) = (self.at.m, self.at.library);
        m.section("Registers: a skid buffer");
        let valid = m.input("valid_i", 1);
        let ready_after = m.input("ready_i", 1);
        let valid = hold.map_or(valid, |hold| valid & !hold);
        let skid = Skid::instance(m, &library.skid, &[("valid_i", valid), ("ready_i", ready_after)]);
        m.output("ready_o", hold.map_or(skid.ready, |hold| skid.ready & !hold));
        m.output("valid_o", skid.valid);
        if self.is_gated() {
            // What is in the spare registers moves whole: they hold a job only after a stall.
            let waits = (skid.arrives & !skid.load_front).named("waits").comment("an arriving job cannot leave");
            self.store_gated(|uses, group| {
                let spare = Gate::new(&format!("keep_{group}"), uses.map_or(waits, |uses| waits & uses));
                let moves = uses.map_or(skid.load_front, |uses| skid.load_front & (uses | !skid.arrives));
                let front = Gate::new(&format!("load_{group}"), moves);
                move |name, word| {
                    let kept = spare.register(m, &format!("{name}_spare_q"), word);
                    vec![kept, front.register(m, &format!("{name}_q"), skid.arrives.mux(word, kept.wire()))]
                }
            });
            return valid & skid.ready;
        }
        let ports = [("valid_i", valid), ("ready_i", ready_after), ("ready_o", skid.ready), ("valid_o", skid.valid)];
        self.store("u_skid", &library.skid_buffer, &ports, |name, wire| skid.store(m, name, wire).to_vec());
        valid & skid.ready
    }

    /// Adds registers that take a job in every cycle.
    pub fn plain(self) -> Wire<'m> {
        let (m, library) = (self.at.m, self.at.library);
        m.section("Registers, which never stall");
        let valid = m.input("valid_i", 1);
        let register = Plain::new(m, valid);
        m.output("valid_o", register.valid.wire());
        if self.is_gated() {
            self.store_gated(|uses, group| {
                let load = Gate::new(&format!("load_{group}"), uses.map_or(valid, |uses| valid & uses));
                move |name, word| vec![load.register(m, &format!("{name}_q"), word)]
            });
            return valid;
        }
        if !self.at.plan.steps[self.at.step].delays.is_empty() || self.next.iter().any(|next| next.is_inside) {
            self.delayed();
            return valid;
        }
        let ports = [("valid_i", valid), ("valid_o", register.valid.wire())];
        let mut own = Some(register.valid);
        self.store("u_register", &library.register, &ports, |name, wire| {
            own.take().into_iter().chain([register.store(m, name, wire)]).collect()
        });
        valid
    }

    /// Adds the FIFO at the exit: a register that the sink sees, and `depth` jobs behind it.
    pub fn exit(self, depth: u32) -> Result<Wire<'m>, Error> {
        let m = self.at.m;
        if depth > MOST_REGISTERS {
            return self.deep_exit(depth);
        }
        m.section("Registers: a FIFO with a place for every job that holds a credit");
        let valid = m.input("valid_i", 1);
        let ready_after = m.input("ready_i", 1);
        let inputs = [("valid_i", valid), ("ready_i", ready_after)];
        let exit = Exit::instance(m, &Exit::module(depth)?, &inputs);
        m.output("valid_o", exit.valid);
        if self.is_gated() {
            self.store_gated(|uses, group| {
                let places = (0..depth).map(|place| {
                    let stores = exit.store.bit(place);
                    Gate::new(&format!("store_{place}_{group}"), uses.map_or(stores, |uses| stores & uses))
                });
                let places: Vec<Gate<'m>> = places.collect();
                let moves = uses.map_or(exit.load_front, |uses| exit.load_front & (uses | exit.from_store));
                let front = Gate::new(&format!("load_{group}"), moves);
                move |name, word| {
                    exit.store_with(m, name, word, |place, register, next| match place {
                        Some(place) => places[place as usize].load(register, next),
                        None => front.load(register, next),
                    })
                }
            });
            return Ok(valid);
        }
        let ports = [inputs[0], inputs[1], ("valid_o", exit.valid)];
        self.store("u_exit", &Exit::buffer(depth)?, &ports, |name, wire| exit.store(m, name, wire));
        Ok(valid)
    }

    /// Adds registers, and memories and wires in place of some of them, and their ports.
    fn delayed(self) {
        let StepBuilder { m, plan, step, .. } = self.at;
        let delays = plan.steps[step].delays.iter().map(|(place, delay)| (number(*place), *delay));
        let delays: BTreeMap<String, Delay> = delays.collect();
        let mut shown: BTreeMap<&str, Wire<'m>> = BTreeMap::new();
        let mut lines: BTreeMap<u32, Vec<&Next<'m>>> = BTreeMap::new();
        for next in &self.next {
            match delays.get(&next.name).copied().or(next.is_inside.then_some(Delay::Wires)) {
                Some(Delay::Memory(cycles)) => lines.entry(cycles).or_default().push(next),
                Some(Delay::Wires) => {
                    shown.insert(&next.name, next.wire);
                }
                None => {
                    let register = m.register(&format!("{}_q", next.name), next.wire.width());
                    register.next(next.wire);
                    shown.insert(&next.name, register.wire());
                }
            }
        }
        for (cycles, words) in lines {
            m.section(format!("Numbers that wait: a memory shows each {cycles} cycles later"));
            // The word at the place that is written now is read before: it was written as many cycles ago as the memory
            // has places, and is shown a cycle later.
            let places = cycles - 1;
            let width = (places - 1).ilog2() + 1;
            let place = m.register(&format!("place_of_{places}_q"), width).reset_to(0);
            let is_last = place.wire().is(u64::from(places - 1));
            place.next((place.wire() + m.constant(width, 1)) & (!is_last).replicate(width));
            let always = (m.constant(1, 1), place.wire());
            let read = memory(m, &format!("u_wait_{cycles}"), places, &words, [always; 2]);
            for (next, column) in words.into_iter().zip(read) {
                shown.insert(&next.name, column);
            }
        }
        self.show(|name| shown[name]);
    }

    /// The FIFO at the exit with a memory for most of its jobs. Behind the two registers of [`Exit`] is the next job, in
    /// a register or as the memory has read it, and behind that the memory. It has jobs only while all of these are
    /// full, and is read as one of them becomes free, so the sink sees what it would see of registers alone.
    fn deep_exit(self, depth: u32) -> Result<Wire<'m>, Error> {
        let m = self.at.m;
        m.section("Registers, and a memory, with a place for every job that holds a credit");
        let (valid, ready_after) = (m.input("valid_i", 1), m.input("ready_i", 1));
        let arrives = m.forward("arrives", 1);
        let exit = Exit::instance(m, &Exit::module(1)?, &[("valid_i", arrives.wire()), ("ready_i", ready_after)]);
        m.output("valid_o", exit.valid);

        let width = depth.ilog2() + 1;
        let counter = |name: &str, width: u32| m.register(name, width).reset_to(0);
        let (waiting, next_full, is_read) =
            (counter("waiting_q", width + 1), counter("next_full_q", 1), counter("is_read_q", 1));
        let (write, read) = (counter("write_q", width), counter("read_q", width));
        let takes =
            (!(exit.valid & exit.from_store) | ready_after).named("takes").comment("the registers have a place");
        let is_any = waiting.wire().any().named("is_any_waiting");
        let passes = (valid & takes & !next_full.wire()).named("passes");
        let moves_up = (valid & !passes & !is_any & (takes | !next_full.wire())).named("moves_up");
        let stores = (valid & !passes & !moves_up).named("stores");
        let fetches = (is_any & takes).named("fetches");
        arrives.drive(passes | (next_full.wire() & takes));
        next_full.next(moves_up | fetches | (next_full.wire() & !takes));
        is_read.next_when(moves_up | fetches, fetches);
        waiting.next(waiting.wire() + stores.extend(width + 1) - fetches.extend(width + 1));
        for (pointer, turns) in [(write, stores), (read, fetches)] {
            pointer.next(pointer.wire() + turns.extend(width));
        }
        let all: Vec<&Next<'m>> = self.next.iter().collect();
        let oldest = memory(m, "u_waiting", 1 << width, &all, [(stores, write.wire()), (fetches, read.wire())]);
        let mut shown: BTreeMap<&str, Wire<'m>> = BTreeMap::new();
        for (next, oldest) in all.into_iter().zip(oldest) {
            let behind = m.register(&format!("{}_behind_q", next.name), next.wire.width());
            behind.next_when(moves_up, next.wire);
            let behind = is_read.wire().mux(oldest, behind.wire());
            let word = next_full.wire().mux(behind, next.wire).named(&format!("{}_next", next.name));
            let registers = exit.store(m, &next.name, word);
            shown.insert(&next.name, registers[registers.len() - 1].wire());
        }
        self.show(|name| shown[name]);
        Ok(valid)
    }

    fn is_gated(&self) -> bool {
        self.at.plan.microarchitecture.clock_gating
    }

    /// Adds the data registers behind clock gates, and their ports. Registers that the same operations use are a group.
    /// `of_group` is called with whether the arriving job uses the group, if not all jobs do, and the name of the
    /// group. It gives what makes the registers of a word, the one that is shown last.
    fn store_gated<R: FnMut(&str, Wire<'m>) -> Vec<Register<'m>>>(
        self,
        mut of_group: impl FnMut(Option<Wire<'m>>, &str) -> R,
    ) {
        let StepBuilder { m, plan, opcode, .. } = self.at;
        let mut groups: BTreeMap<&BTreeSet<usize>, Vec<&Next<'m>>> = BTreeMap::new();
        for next in &self.next {
            groups.entry(&next.users).or_default().push(next);
        }
        let mut shown: BTreeMap<&str, Wire<'m>> = BTreeMap::new();
        for (users, registers) in groups {
            let is_all = users.len() == plan.operations.len();
            let names: Vec<&str> = users.iter().map(|&op| plan.operations[op].name).collect();
            let group = if is_all { "all".to_string() } else { names.join("_") };
            let is = |&op: &usize| opcode.equals(m.label(&label(&plan.operations[op]), opcode.width()));
            let uses = users.iter().map(is).reduce(|a, b| a | b).filter(|_| !is_all);
            let uses = uses.map(|uses| uses.named(&format!("uses_{group}")));
            let mut make = of_group(uses, &group);
            for Next { name, wire, .. } in registers {
                shown.insert(name, make(name, *wire)[..].last().map_or(*wire, |register| register.wire()));
            }
        }
        self.show(|name| shown[name]);
    }

    /// Adds the output ports, in the order of the structure. `shown` gives the wire of a word.
    fn show(&self, shown: impl Fn(&str) -> Wire<'m>) {
        let m = self.at.m;
        self.next.iter().for_each(|Next { name, .. }| m.output(&format!("{name}_o"), shown(name)));
        m.group_outputs(self.output.clone());
    }

    /// Adds the data registers that `registers` gives for each word, the one that is shown last, and their ports.
    fn store(
        self,
        instance: &str,
        buffer: &Arc<Module>,
        ports: &[(&str, Wire<'m>)],
        mut registers: impl FnMut(&str, Wire<'m>) -> Vec<Register<'m>>,
    ) {
        let mut all = Vec::new();
        for Next { name, wire, .. } in &self.next {
            let own = registers(name, *wire);
            self.at.m.output(&format!("{name}_o"), own[own.len() - 1].wire());
            all.extend(own);
        }
        let of = |port: &str| self.next.iter().find(|next| port == format!("{}_o", next.name));
        let next: Vec<Wire<'m>> = self.output.members.iter().filter_map(|(port, _)| of(port)).map(|n| n.wire).collect();
        self.at.m.bank(instance, buffer, ports, &next, &all, self.output);
    }
}

/// A memory of these words, with the enables and addresses of its writes and of its reads. Returns what it has read.
fn memory<'m>(
    m: &'m Builder,
    name: &str,
    depth: u32,
    words: &[&Next<'m>],
    [write, read]: [(Wire<'m>, Wire<'m>); 2],
) -> Vec<Wire<'m>> {
    let columns: Vec<(&str, u32)> = words.iter().map(|next| (next.name.as_str(), next.wire.width())).collect();
    let memory = m.memory(name, depth, &columns);
    memory.write(write.0, write.1, &words.iter().map(|next| next.wire).collect::<Vec<_>>());
    memory.read(read.0, read.1)
}
