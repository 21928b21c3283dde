//! Prints a netlist as SystemVerilog in the style of lowRISC.
//!
//! The text of a module has its sections in order. A section has the declarations of the signals that it drives or
//! reads first, then assignments and instances in the order of building, then registers. An expression without a name
//! is written inside its only reader if it is short; otherwise it gets a name derived from that reader.

mod entries;
mod expression;
mod gate;
mod hierarchy;
mod labels;
mod layout;
mod package;
mod plan;
mod ram;
mod statements;
mod structures;

use crate::netlist::{Module, gated_clock};
use crate::{Error, SignalId};
use entries::{Entry, Section};
pub use gate::CLOCK_GATE;
pub use hierarchy::{Source, modules, sources, text};
pub use layout::wrap;
use layout::{comment, logic};
pub use package::print_package;
use plan::Plan;
pub use ram::{RAM, RAM_TEXT};
pub use statements::Connections;
use std::collections::HashSet;

/// The licence: the first comment of every file.
pub const LICENSE: &str = "SPDX-License-Identifier: MIT OR Apache-2.0";

/// The SystemVerilog text of one module, without those that it instantiates and the package that it refers to; see
/// [`sources`]. The lines of `banner` become its head comment, followed by the module's own.
pub fn print_module(module: &Module, banner: &[String]) -> Result<String, Error> {
    let mut lines = head_comment(banner, module.doc());
    if let Some((text, _)) = &module.text().verbatim {
        return Ok(lines.into_iter().map(|line| line + "\n").collect::<String>() + text);
    }
    let plan = Plan::new(module);
    lines.extend(ports(module));
    lines.extend(plan.labels().declarations());
    lines.extend(enumerated_input(module));
    let mut declared = HashSet::new();
    for section in plan.sections() {
        lines.extend(print_section(&plan, section, &mut declared));
    }
    lines.extend([String::new(), format!("endmodule : {}", module.name())]);
    Ok(lines.into_iter().map(|line| line + "\n").collect())
}

/// The head of a file: the licence, the lines of `banner` and those of `doc` as a comment, then a blank line.
pub fn head(banner: &[String], doc: &[String]) -> String {
    let banner: Vec<String> = std::iter::once(LICENSE.to_string()).chain(banner.iter().cloned()).collect();
    head_comment(&banner, doc).into_iter().map(|line| line + "\n").collect()
}

fn head_comment(banner: &[String], doc: &[String]) -> Vec<String> {
    let comments = |texts: &[String]| -> Vec<String> {
        texts
            .iter()
            .flat_map(|text| text.split('\n').map(str::to_string).collect::<Vec<_>>())
            .flat_map(|line| comment(&line))
            .collect()
    };
    let mut lines = comments(banner);
    if !banner.is_empty() && !doc.is_empty() {
        lines.extend(comment(""));
    }
    lines.extend(comments(doc));
    if !lines.is_empty() {
        lines.push(String::new());
    }
    lines
}

fn ports(module: &Module) -> Vec<String> {
    let mut rows: Vec<(String, String, Option<String>)> = Vec::new();
    let mut row = |kind: String, name: &str, remark: Option<String>| rows.push((kind, format!("{name},"), remark));
    for (name, is_there) in [("clk_i", module.is_clocked()), ("rst_ni", module.has_reset())] {
        if is_there {
            row("input  logic".to_string(), name, None);
        }
    }
    let text = module.text();
    let outputs: Vec<&crate::text::PortGroup> = text.output().into_iter().collect();
    let groups = [("input ", text.inputs.iter().collect()), ("output", outputs)];
    for ((direction, groups), ports) in groups.into_iter().zip([module.inputs(), module.outputs()]) {
        for port in ports {
            match groups.iter().find(|group| group.contains(&port.name)) {
                None => {
                    let signal = module.signal(port.signal);
                    // A named signal at an output port has its remark beside its own declaration.
                    let remark = signal.comment.clone().filter(|_| direction == "input " || signal.name.is_none());
                    row(format!("{direction} {}", logic(module, signal.width)), &port.name, remark);
                }
                Some(group) if group.begins_with(&port.name) => {
                    row(format!("{direction} {}", group.structure), &group.name, None);
                }
                Some(_) => {}
            }
        }
    }
    // Ports of a channel follow each other, the others before them.
    let channel = |(_, name, _): &(String, String, _)| {
        text.channels.iter().position(|(prefix, _)| name.starts_with(prefix)).map_or(0, |place| place + 1)
    };
    rows.sort_by_key(&channel);
    let places: Vec<usize> = rows.iter().map(channel).collect();
    let parameter = match text.has_width_parameter {
        true => " #(\n  parameter logic [31:0] Width = 1\n)",
        false => "",
    };
    match rows.last_mut() {
        None => return vec![format!("module {}{parameter};", module.name())],
        Some((_, last, _)) => last.truncate(last.len() - 1),
    }
    let mut lines = vec![format!("module {}{parameter} (", module.name())];
    let mut last = 0;
    for (place, declaration) in places.into_iter().zip(layout::each_declaration("  ", &rows)) {
        if place != last {
            lines.extend(comment(&text.channels[place - 1].1).into_iter().map(|line| format!("  {line}")));
        }
        lines.extend(declaration);
        last = place;
    }
    lines.push(");".to_string());
    lines
}

/// The variable through which the module reads an input port as an enumeration.
fn enumerated_input(module: &Module) -> Vec<String> {
    let Some(input) = &module.text().enumerated else { return Vec::new() };
    vec![
        String::new(),
        format!("  {} {};", input.structure, input.variable),
        String::new(),
        format!("  assign {} = {};", input.variable, input.port),
    ]
}

fn print_section(plan: &Plan<'_>, section: &Section<'_>, declared: &mut HashSet<SignalId>) -> Vec<String> {
    let declarations = declarations(plan, section, declared);
    let statements = statements::print(plan, &section.entries);
    let mut lines = Vec::new();
    if let Some(title) = section.title.filter(|_| !declarations.is_empty() || !statements.is_empty()) {
        lines.extend([String::new(), layout::title(title)]);
    }
    let untitled = section.title.is_none();
    if !declarations.is_empty() {
        lines.extend(untitled.then(String::new));
        lines.extend_from_slice(&declarations);
    }
    if !statements.is_empty() {
        lines.extend((untitled || !declarations.is_empty()).then(String::new));
        lines.extend(statements);
    }
    lines
}

/// The signals that the section drives or is the first to read, except ports, so that declarations precede uses.
fn declarations(plan: &Plan<'_>, section: &Section<'_>, declared: &mut HashSet<SignalId>) -> Vec<String> {
    let mut new: Vec<SignalId> =
        section.entries.iter().flat_map(|e| plan.mentioned(e)).filter(|&id| declared.insert(id)).collect();
    new.sort();
    let mut rows: Vec<(String, String, Option<String>)> = Vec::new();
    for id in new {
        if let Some(name) = plan.declaration(id) {
            let signal = plan.module().signal(id);
            // The remark of a nameless signal that drives only this one is printed here, because it has no declaration.
            let driver = plan.module().signal(plan.driven_by(id));
            let remark = signal.comment.as_ref().or(driver.comment.as_ref());
            rows.push((logic(plan.module(), signal.width), format!("{name};"), remark.cloned()));
        }
    }
    let mut structures: Vec<(String, String, Option<String>)> = Vec::new();
    for entry in &section.entries {
        match entry {
            Entry::Unused(name, _) => rows.push(("logic".to_string(), format!("{name};"), None)),
            Entry::Registers(group) if statements::begins_gate(plan.module(), group) => {
                let enable = plan.module().registers()[group[0]].enable;
                let clock = enable.and_then(|enable| plan.module().signal(enable).name.as_deref()).map(gated_clock);
                rows.extend(clock.map(|clock| ("logic".to_string(), format!("{clock};"), None)));
            }
            Entry::Instance(index) => {
                let group = plan.module().instances()[*index].module.text().output();
                if let (Some(group), Some(variable)) = (group, plan.structures().of_instance(*index)) {
                    structures.push((group.structure.clone(), format!("{variable};"), None));
                }
            }
            Entry::Bank(bank, _) => {
                structures.push((bank.output.structure.clone(), format!("{};", plan.structures().next()), None));
            }
            _ => {}
        }
    }
    let mut lines = layout::declarations("  ", &rows);
    lines.extend(layout::declarations("  ", &structures));
    lines
}
