//! One step as a module: aliases for the registers before it, its units, and the registers after it.

use crate::allocate::plan::Plan;
use crate::config::{Control, Encoding};
use crate::emit::boundary::{self, StepBuilder};
use crate::emit::elastic::Registers;
use crate::emit::folded::Folded;
use crate::emit::interface;
use crate::emit::library::Library;
use crate::emit::positions::Positions;
use crate::emit::values::{StepInputs, Values};
use crate::error::Error;
use crate::ir::graph::{Kind, NodeId, Op, OperationGraph, StateValue};
use crate::ir::position::{Step, StepLabel};
use raypath_float::Format;
use raypath_hdl::text::Package;
use raypath_hdl::{Builder, Module, Register, Wire};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The module `raypath_stage_<stage>`, or `raypath_stage_<stage>_<part>` where the stage has several steps.
pub fn stage(plan: &Plan, library: &Library, package: &Arc<Package>, step: usize) -> Result<Arc<Module>, Error> {
    // The first build finds the values that are read by name; the second one declares their names first.
    let scratch = Builder::new("scratch");
    let read = build(&scratch, plan, library, step, &[])?;
    let m = Builder::new(&format!("raypath_{}", interface::step_name(plan.steps[step].label)));
    m.package(package);
    describe(&m, plan, step);
    build(&m, plan, library, step, &read)?;
    Ok(m.finish()?)
}

/// Builds a step that begins with `names` as aliases for the registers before it. Returns the aliases that it needs.
fn build(
    m: &Builder,
    plan: &Plan,
    library: &Library,
    step: usize,
    names: &[(usize, NodeId)],
) -> Result<Vec<(usize, NodeId)>, Error> {
    let opcode = m.input("opcode_i", plan.opcode_width());
    let positions = Positions::new(m, plan);
    if plan.rounds.is_some() && step == plan.last() {
        m.enumerate_input(interface::opcode_input());
    }
    let at = StepBuilder { m, plan, library, step, opcode, positions: Some(&positions) };
    let mut before = StepInputs::ports(m, plan, library, step);
    if plan.rounds.is_none() {
        m.group_inputs(interface::input(plan, library, step - 1));
    }
    let states = States::new(at);
    before.states = states.wires.clone();
    let mut values = Values::new(at, before);

    for (op, traced) in plan.operations.iter().enumerate() {
        let mut names = names.iter().filter(|(whose, _)| *whose == op).peekable();
        if names.peek().is_some() {
            m.section(format!("Register aliases for {}", traced.name));
        }
        for &(op, id) in names {
            values.get(op, id)?;
        }
    }
    let units = plan.units(step);
    if !units.is_empty() {
        m.section("Units, shared by the operations");
        for unit in units {
            values.unit(unit)?;
        }
    }
    let last = step == plan.last();
    if let Some(rounds) = plan.rounds.as_ref().filter(|_| !last) {
        Folded::new(at, rounds, None).store(&mut values)?;
        states.write(at, None, &mut values)?;
        return Ok(values.read_from_registers());
    }
    let next = at.next(&mut values)?;
    let registers = Registers::new(at, next);
    let advance = match plan.microarchitecture.control {
        Control::Skid => {
            let busy = Busy::new(at);
            let hold = busy.iter().map(|busy| busy.hold).reduce(|a, b| a | b);
            let advance = registers.skid_buffers(hold);
            busy.into_iter().for_each(|busy| busy.follow(advance));
            advance
        }
        Control::Credit if last => registers.exit(plan.capacity() as u32 - 1)?,
        Control::Credit => registers.plain(),
    };
    states.write(at, Some(advance), &mut values)?;
    Ok(values.read_from_registers())
}

/// The head comment: the row of Table VII.
fn describe(m: &Builder, plan: &Plan, step: usize) {
    let at = plan.steps[step].label;
    m.doc(match at {
        StepLabel { stage, parts: 1, .. } => format!("Stage {stage} and the registers after it."),
        StepLabel { stage, part, parts } => {
            format!("Stage {stage}, step {part} of {parts}, and the registers after it.")
        }
    });
    for traced in &plan.operations {
        let what = notes(plan, traced, step);
        m.doc(format!("  {:<10} {}", format!("{}:", traced.name), if what.is_empty() { "passes" } else { &what }));
    }
    let after = &plan.steps[step].layout;
    if after.numbers > 0 {
        m.doc("Number registers after it:");
    }
    for place in 0..after.numbers {
        m.doc(format!("  {:<8} {}", format!("num[{place}]"), boundary::live_value_names(plan, after, place)));
    }
    if after.flags > 0 {
        m.doc("Flag registers after it, lowest bit first:");
        for (op, traced) in plan.operations.iter().enumerate() {
            m.doc(format!("  {:<10} {}", format!("{}:", traced.name), boundary::live_flag_names(plan, after, op)));
        }
    }
}

/// The description of an operation's work in a step's stage, and of the conversions of all numbers there.
pub fn notes(plan: &Plan, traced: &OperationGraph<Step>, index: usize) -> String {
    let label = plan.steps[index].label;
    let own = traced.notes.iter().filter(|(at, _)| *at == label.stage).map(|(_, what)| what.as_ref());
    let ieee = if plan.format == Format::BINARY32 { "binary32" } else { "IEEE 754" };
    let conversion = match index.checked_sub(1).map(|before| (plan.encoding(before), plan.encoding(index))) {
        Some((Encoding::Ieee, Encoding::Recoded)) => Some(format!("{ieee} to recoded")),
        Some((Encoding::Recoded, Encoding::Ieee)) => Some(format!("recoded to {ieee}")),
        _ => None,
    };
    conversion.into_iter().chain(own.map(str::to_string)).collect::<Vec<_>>().join("; ")
}

/// The state that a step reads or writes.
struct States<'m> {
    /// State that the step writes: registers, zero after reset.
    registers: BTreeMap<(usize, usize), Register<'m>>,
    /// State that the step reads.
    wires: BTreeMap<(usize, usize), Wire<'m>>,
}

impl<'m> States<'m> {
    fn new(StepBuilder { m, plan, library, step, .. }: StepBuilder<'m, '_>) -> Self {
        let mut states = Self { registers: BTreeMap::new(), wires: BTreeMap::new() };
        let all = || {
            plan.operations.iter().enumerate().flat_map(|(op, t)| t.states.iter().enumerate().map(move |s| (op, t, s)))
        };
        let reads = |op: usize, traced: &OperationGraph<Step>, number: usize| {
            let mut operands = plan.steps[step].made[op].iter().flat_map(|&id| traced.operands(id));
            operands.any(|id| traced.node(id).op == Op::State(number))
        };
        for (op, traced, (number, state)) in all() {
            if state.written != Step(step as u32) && reads(op, traced, number) {
                let port = m.input(&format!("{}_i", port(traced, state)), width(traced, state, library));
                states.wires.insert((op, number), port);
            }
        }
        if all().any(|(_, _, (_, state))| state.written == Step(step as u32)) {
            m.section("State: changes once for each job, when the job leaves the step");
        }
        for (op, traced, (number, state)) in all().filter(|(_, _, (_, state))| state.written == Step(step as u32)) {
            let register = m.register(&format!("{}_q", port(traced, state)), width(traced, state, library)).reset_to(0);
            states.registers.insert((op, number), register);
            states.wires.insert((op, number), register.wire());
        }
        states
    }

    /// Sets the next values of the registers. `advance` is whether the job leaves the step; a folded pipeline has a
    /// position for each state instead.
    fn write(
        self,
        at: StepBuilder<'m, '_>,
        advance: Option<Wire<'m>>,
        values: &mut Values<'m, '_>,
    ) -> Result<(), Error> {
        let StepBuilder { m, plan, opcode, .. } = at;
        if self.registers.is_empty() {
            return Ok(());
        }
        m.section("The job leaves the step");
        let advance = advance.map(|advance| advance.named("advance"));
        if let (Some(rounds), Some(positions)) = (&plan.rounds, at.positions) {
            for ((op, number), register) in self.registers {
                let traced = &plan.operations[op];
                let moves = positions.moves(rounds.states[op][number]);
                let state = &traced.states[number];
                register.next_when(moves & is(opcode, traced), values.get(op, state.next)?);
                if state.read < state.written {
                    m.output(&format!("{}_o", port(traced, state)), register.wire());
                }
            }
            return Ok(());
        }
        let Some(advance) = advance else { return Ok(()) };
        let mut advances: BTreeMap<usize, Wire<'_>> = BTreeMap::new();
        for ((op, number), register) in self.registers {
            let traced = &plan.operations[op];
            let state = &traced.states[number];
            let next = values.get(op, state.next)?;
            let named = || (advance & is(opcode, traced)).named(&format!("{}_advances", traced.name));
            let advances = *advances.entry(op).or_insert_with(named);
            match plan.microarchitecture.clock_gating {
                true => register.next_gated(advances, next),
                false => register.next_when(advances, next),
            }
            if state.read < state.written {
                m.output(&format!("{}_o", port(traced, state)), register.wire());
            }
        }
        for (op, advances) in advances {
            if plan.microarchitecture.control == Control::Skid && plan.operations[op].is_loop() {
                m.output(&format!("{}_o", written(&plan.operations[op])), advances);
            }
        }
        Ok(())
    }
}

/// Whether the job belongs to an operation.
fn is<'m>(opcode: Wire<'m>, traced: &OperationGraph<Step>) -> Wire<'m> {
    opcode.equals(opcode.builder().label(&boundary::label(traced), opcode.width()))
}

/// A state as a port, or as the stem of its register.
pub fn port(traced: &OperationGraph<Step>, state: &StateValue<Step>) -> String {
    format!("{}_{}_state", traced.name, state.name)
}

/// The port that signals that an operation has written its state.
fn written(traced: &OperationGraph<Step>) -> String {
    format!("{}_written", traced.name)
}

/// Bits of a state; numbers are recoded.
pub fn width(traced: &OperationGraph<Step>, state: &StateValue<Step>, library: &Library) -> u32 {
    match traced.node(state.next).kind {
        Kind::Word(width) => width,
        Kind::Number | Kind::Order | Kind::Cut(..) => library.format.recoded_width(),
    }
}

/// An operation that reads its state in this step and writes it in a later one: its next job has to wait.
struct Busy<'m> {
    pending: Register<'m>,
    written: Wire<'m>,
    is_own: Wire<'m>,
    /// The job in the registers before must stay there.
    hold: Wire<'m>,
}

impl<'m> Busy<'m> {
    fn new(StepBuilder { m, plan, step, opcode, .. }: StepBuilder<'m, '_>) -> Vec<Self> {
        let loops = plan.operations.iter().filter(|traced| traced.is_loop());
        let here = loops.filter(|traced| traced.first_read() == Step(step as u32));
        here.map(|traced| {
            m.section(format!("A job of {} waits until the job before it has written its state", traced.name));
            let written = m.input(&format!("{}_i", written(traced)), 1);
            let pending = m.register(&format!("{}_pending_q", traced.name), 1).reset_to(0);
            let is_own = is(opcode, traced).named(&format!("is_{}", traced.name));
            let hold = (pending.wire() & is_own).named(&format!("{}_waits", traced.name));
            Self { pending, written, is_own, hold }
        })
        .collect()
    }

    fn follow(self, advance: Wire<'m>) {
        self.pending.next((advance & self.is_own) | (self.pending.wire() & !self.written));
    }
}
