//! One stage as a module: the values of its registers under the algorithm's names, its units, its registers.

use crate::STAGES;
use crate::boundary::{self, OPCODE_WIDTH};
use crate::error::Error;
use crate::graph::{Kind, NodeId, Traced};
use crate::library::Library;
use crate::plan::{Plan, all_units};
use crate::values::{Before, Values};
use raypath_hdl::{Builder, Module, Register, Wire};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The module `raypath_stage_<stage>`, 1 to [`STAGES`].
pub fn stage(plan: &Plan, library: &Library, stage: usize) -> Result<Arc<Module>, Error> {
    // Built once to learn which values are read by name, and once more to name them first.
    let scratch = Builder::new("scratch");
    let read = build(&scratch, plan, library, stage, &[])?;
    let m = Builder::new(&format!("raypath_stage_{stage}"));
    describe(&m, plan, stage);
    build(&m, plan, library, stage, &read)?;
    Ok(m.finish()?)
}

/// Builds a stage whose algorithms begin with `names` for the registers before it. Gives those that it needs.
fn build(
    m: &Builder,
    plan: &Plan,
    library: &Library,
    stage: usize,
    names: &[(usize, NodeId)],
) -> Result<Vec<(usize, NodeId)>, Error> {
    let before = &plan.stages[stage - 1].layout;
    let opcode = m.input("opcode_i", OPCODE_WIDTH);
    let width = number_width(library, stage - 1);
    let number = |place| {
        let port = m.input(&format!("{}_i", boundary::number(place)), width);
        port.comment(boundary::residents(plan, before, place))
    };
    let numbers = (0..before.numbers).map(number).collect();
    let flags = (before.flags > 0).then(|| m.input("flags_i", before.flags));

    let states = state_registers(m, plan, library, stage);
    let state_wires = states.iter().map(|(&key, register)| (key, register.wire())).collect();
    let mut values = Values::new(m, plan, library, stage, opcode, Before { numbers, flags, states: state_wires });

    for (op, traced) in plan.operations.iter().enumerate() {
        let mut names = names.iter().filter(|(whose, _)| *whose == op).peekable();
        if names.peek().is_some() {
            m.section(format!("The registers as {} knows them", traced.name));
        }
        for &(op, id) in names {
            values.get(op, id)?;
        }
    }
    let units = plan.stages[stage].units;
    if all_units(units).next().is_some() {
        m.section("Units, shared by the operations");
        for unit in all_units(units) {
            values.unit(unit)?;
        }
    }
    let handshake = boundary::registers(m, plan, stage, &library.skid, opcode, &mut values)?;

    if !states.is_empty() {
        m.section("The stage hands its job on");
        let advance = (handshake.valid & handshake.ready).named("advance");
        let mut advances: BTreeMap<usize, Wire<'_>> = BTreeMap::new();
        for ((op, state), register) in states {
            let traced = &plan.operations[op];
            let next = values.get(op, traced.states[state].next)?;
            let named = || (advance & opcode.is(traced.opcode)).named(&format!("{}_advances", traced.name));
            register.next_when(*advances.entry(op).or_insert_with(named), next);
        }
    }
    Ok(values.read_from_registers())
}

/// Bits of a number in the registers after `stage`: binary32 at the two ends, recoded between.
pub fn number_width(library: &Library, stage: usize) -> u32 {
    if stage == 0 || stage == STAGES as usize { library.format.ieee_width() } else { library.format.recoded_width() }
}

/// The head comment: Table VII, read along its row.
fn describe(m: &Builder, plan: &Plan, stage: usize) {
    m.doc(format!("Stage {stage} and the registers after it."));
    for traced in &plan.operations {
        let what = notes(traced, stage as u32);
        m.doc(format!("  {:<10} {}", format!("{}:", traced.name), if what.is_empty() { "passes" } else { &what }));
    }
    let after = &plan.stages[stage].layout;
    if after.flags > 0 {
        m.doc("Flags after it, lowest bit first:");
        for (op, traced) in plan.operations.iter().enumerate() {
            m.doc(format!("  {:<10} {}", format!("{}:", traced.name), boundary::flag_residents(plan, after, op)));
        }
    }
}

/// What an operation says that it does in a stage.
pub fn notes(traced: &Traced, stage: u32) -> String {
    let notes: Vec<&str> = traced.notes.iter().filter(|(at, _)| *at == stage).map(|(_, what)| *what).collect();
    match stage {
        1 => "binary32 to recoded".to_string(),
        STAGES => "recoded to binary32".to_string(),
        _ => notes.join("; "),
    }
}

/// The state that operations keep in this stage, zero after reset.
fn state_registers<'m>(
    m: &'m Builder,
    plan: &Plan,
    library: &Library,
    stage: usize,
) -> BTreeMap<(usize, usize), Register<'m>> {
    let mut registers = BTreeMap::new();
    if plan.operations.iter().any(|traced| traced.states.iter().any(|state| state.stage as usize == stage)) {
        m.section("State: changes once for each job, when the stage hands it on");
    }
    for (op, traced) in plan.operations.iter().enumerate() {
        for (number, state) in traced.states.iter().enumerate().filter(|(_, state)| state.stage as usize == stage) {
            let width = match traced.node(state.next).kind {
                Kind::Word(width) => width,
                Kind::Ieee | Kind::Recoded | Kind::Order => library.format.recoded_width(),
            };
            let name = format!("{}_{}_state_q", traced.name, state.name);
            registers.insert((op, number), m.register(&name, width).reset_to(0));
        }
    }
    registers
}
