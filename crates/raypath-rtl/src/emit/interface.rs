//! The package `raypath_pkg`: the opcodes, and the registers after each step as structures.

use crate::allocate::plan::Plan;
use crate::emit::boundary::{flag_register, label, number};
use crate::emit::library::Library;
use crate::ir::position::StepLabel;
use raypath_hdl::text::{EnumeratedInput, Enumeration, Package, PortGroup, Structure};
use std::sync::Arc;

/// The package's name.
pub const PACKAGE: &str = "raypath_pkg";

/// A field of the registers after a step: one port, or an array of ports.
struct Field {
    name: String,
    kind: String,
    /// Stems of ports and their selects in the structure; the most significant first.
    ports: Vec<(String, String)>,
}

/// The declarations that all modules of a datapath share.
pub fn package(plan: &Plan, library: &Library) -> Arc<Package> {
    let mut labels: Vec<_> = plan.operations.iter().map(label).collect();
    labels.sort_by_key(|label| label.value);
    let operation = Structure {
        name: "operation_t".to_string(),
        doc: Some("The opcode port as an enumeration.".to_string()),
        fields: vec![("opcode_e".to_string(), "opcode".to_string())],
    };
    // The registers of a folded pipeline hold values of several positions, except those at the exit.
    let first = if plan.rounds.is_some() { plan.last() } else { 0 };
    let registers = (first..plan.steps.len()).map(|step| Structure {
        name: structure(plan, step),
        doc: Some(match step {
            0 => "The input registers.".to_string(),
            _ => format!("The registers after step {}.", plan.steps[step].label),
        }),
        fields: fields(plan, library, step).into_iter().map(|field| (field.kind, field.name)).collect(),
    });
    Arc::new(Package {
        name: PACKAGE.to_string(),
        doc: vec!["The opcodes, and what the registers between the stages hold.".to_string()],
        enumerations: vec![Enumeration { name: "opcode_e".to_string(), doc: None, width: plan.opcode_width(), labels }],
        structures: std::iter::once(operation).chain(registers).collect(),
    })
}

/// The registers after a step as the input port `data_i`.
pub fn input(plan: &Plan, library: &Library, step: usize) -> PortGroup {
    group(plan, library, step, "i")
}

/// The registers after a step as the output port `data_o`.
pub fn output(plan: &Plan, library: &Library, step: usize) -> PortGroup {
    group(plan, library, step, "o")
}

/// The port `opcode_i`, a vector, as an opcode.
pub fn opcode_input() -> EnumeratedInput {
    EnumeratedInput {
        port: "opcode_i".to_string(),
        variable: "operation".to_string(),
        structure: format!("{PACKAGE}::operation_t"),
        field: "opcode".to_string(),
    }
}

/// The name of a step's instance: `stage_3`, `stage_3_2`.
pub fn step_name(label: StepLabel) -> String {
    match label {
        StepLabel { stage: 0, .. } => "input".to_string(),
        StepLabel { stage, parts: 1, .. } => format!("stage_{stage}"),
        StepLabel { stage, part, .. } => format!("stage_{stage}_{part}"),
    }
}

fn structure(plan: &Plan, step: usize) -> String {
    format!("{}_t", step_name(plan.steps[step].label))
}

fn group(plan: &Plan, library: &Library, step: usize, direction: &str) -> PortGroup {
    let ports = fields(plan, library, step).into_iter().flat_map(|field| field.ports);
    PortGroup {
        name: format!("data_{direction}"),
        structure: format!("{PACKAGE}::{}", structure(plan, step)),
        members: ports.map(|(stem, select)| (format!("{stem}_{direction}"), select)).collect(),
    }
}

fn fields(plan: &Plan, library: &Library, step: usize) -> Vec<Field> {
    let layout = &plan.steps[step].layout;
    let word = |name: String, kind: String| Field { ports: vec![(name.clone(), format!(".{name}"))], name, kind };
    let vector = |width: u32| if width == 1 { "logic".to_string() } else { format!("logic [{}:0]", width - 1) };
    let mut fields = vec![word("opcode".to_string(), "opcode_e".to_string())];
    if layout.numbers > 0 {
        fields.push(Field {
            name: "num".to_string(),
            kind: format!("logic [{}:0][{}:0]", layout.numbers - 1, plan.number_width(step) - 1),
            ports: (0..layout.numbers).rev().map(|place| (number(place), format!(".num[{place}]"))).collect(),
        });
    }
    for &unit in &layout.cuts {
        fields.extend(library.cut(unit).map(|(stem, width)| word(format!("{}_{stem}", unit.stem()), vector(width))));
    }
    for (register, width) in layout.flag_registers().enumerate() {
        fields.push(word(flag_register(layout, register), vector(width)));
    }
    fields
}
