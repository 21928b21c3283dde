//! Statements as text.

use super::entries::{Entry, is_case};
use super::expression::constant;
use super::layout::{table, wrap};
use super::plan::Plan;
use crate::netlist::{Arm, Driver, SignalId};

/// The statements of a section: assignments in columns, blocks with blank lines around them.
pub fn print(plan: &Plan<'_>, entries: &[Entry<'_>]) -> Vec<String> {
    let mut text = Text::default();
    for entry in entries {
        match entry {
            Entry::Signal(id) if is_case(plan.module(), plan.driven_by(*id)) => {
                text.block(cases(plan, &[(plan.read(*id), plan.driven_by(*id))]));
            }
            Entry::Signal(id) => text.assign(plan.read(*id), plan.expression(*id)),
            Entry::Cases(group) => {
                let targets: Vec<_> = group.iter().map(|&id| (plan.read(id), id)).collect();
                text.block(cases(plan, &targets));
            }
            Entry::Instance(index) => text.block(instance(plan, *index)),
            Entry::Registers(group) => text.block(registers(plan, group)),
            Entry::Unused(name, ids) => text.assign(name, unused(plan, ids)),
            Entry::Output(index) => {
                let port = &plan.module().outputs()[*index];
                if !plan.is_renamed(port.signal) {
                    text.assign(&port.name, plan.read(port.signal).to_string());
                } else if is_case(plan.module(), port.signal) {
                    text.block(cases(plan, &[(&port.name, port.signal)]));
                } else {
                    text.assign(&port.name, plan.expression(port.signal));
                }
            }
        }
    }
    text.finish()
}

#[derive(Default)]
struct Text {
    lines: Vec<String>,
    /// Assignments since the last block.
    assignments: Vec<[String; 2]>,
}

impl Text {
    fn assign(&mut self, target: &str, expression: String) {
        self.assignments.push([format!("assign {target}"), format!("= {expression};")]);
    }

    fn block(&mut self, lines: Vec<String>) {
        let assignments = table("  ", &std::mem::take(&mut self.assignments));
        for block in [assignments, lines].into_iter().filter(|block| !block.is_empty()) {
            if !self.lines.is_empty() {
                self.lines.push(String::new());
            }
            self.lines.extend(block.into_iter().flat_map(wrap));
        }
    }

    fn finish(mut self) -> Vec<String> {
        self.block(Vec::new());
        self.lines
    }
}

/// One `case` that drives all `targets`, which share a selector and labels. It is not `unique`: with a default that
/// says nothing, and slang reports it.
fn cases(plan: &Plan<'_>, targets: &[(&str, SignalId)]) -> Vec<String> {
    let alternatives = |id: SignalId| match &plan.module().signal(id).driver {
        Driver::Case { selector, arms, default } => Some((*selector, arms.as_slice(), *default)),
        _ => None,
    };
    let targets: Vec<(&str, SignalId, &[Arm], SignalId)> = targets
        .iter()
        .filter_map(|&(name, id)| alternatives(id).map(|(selector, arms, default)| (name, selector, arms, default)))
        .collect();
    let Some(&(_, selector, labels, _)) = targets.first() else { return Vec::new() };
    let mut rows: Vec<(String, Vec<SignalId>)> = Vec::new();
    for (place, arm) in labels.iter().enumerate() {
        let values: Vec<SignalId> = targets.iter().map(|(_, _, arms, _)| arms[place].value).collect();
        match rows.last_mut() {
            Some((label, last)) if *last == values => label.push_str(&format!(", {}", arm.label.name)),
            _ => rows.push((arm.label.name.clone(), values)),
        }
    }
    rows.push(("default".to_string(), targets.iter().map(|(.., default)| *default).collect()));

    let mut lines = vec!["  always_comb begin".to_string(), format!("    case ({})", plan.read(selector))];
    if let [(target, ..)] = targets.as_slice() {
        let row = |(label, values): &(String, Vec<SignalId>)| {
            [format!("{label}:"), format!("{target} = {};", plan.read(values[0]))]
        };
        lines.extend(table("      ", &rows.iter().map(row).collect::<Vec<_>>()));
    } else {
        for (label, values) in &rows {
            let assignments: Vec<[String; 2]> = targets
                .iter()
                .zip(values)
                .map(|((target, ..), &value)| [target.to_string(), format!("= {};", plan.read(value))])
                .collect();
            lines.push(format!("      {label}: begin"));
            lines.extend(table("        ", &assignments));
            lines.push("      end".to_string());
        }
    }
    lines.extend(["    endcase", "  end"].map(String::from));
    lines
}

fn instance(plan: &Plan<'_>, index: usize) -> Vec<String> {
    let instance = &plan.module().instances()[index];
    let inside = &instance.module;
    let mut rows: Vec<[String; 2]> = Vec::new();
    for (name, present) in [("clk_i", inside.is_clocked()), ("rst_ni", inside.has_reset())] {
        if present {
            rows.push([format!(".{name}"), format!("({name}),")]);
        }
    }
    let ports = inside.inputs().iter().zip(&instance.inputs).chain(inside.outputs().iter().zip(&instance.outputs));
    rows.extend(ports.map(|(port, &id)| [format!(".{}", port.name), format!("({}),", plan.read(id))]));
    match rows.last_mut() {
        None => return vec![format!("  {} {} ();", inside.name(), instance.name)],
        Some(last) => last[1].truncate(last[1].len() - 1),
    }
    let mut lines = vec![format!("  {} {} (", inside.name(), instance.name)];
    lines.extend(table("    ", &rows));
    lines.push("  );".to_string());
    lines
}

/// Registers that share their enable and either all have a reset or none.
fn registers(plan: &Plan<'_>, group: &[usize]) -> Vec<String> {
    let infos: Vec<_> = group.iter().map(|&index| &plan.module().registers()[index]).collect();
    let enable = infos[0].enable.map(|id| plan.read(id));
    let assignments = |indent: &str, value: &dyn Fn(usize) -> String| {
        let rows = infos.iter().enumerate();
        let rows: Vec<_> =
            rows.map(|(i, info)| [plan.read(info.signal).to_string(), format!("<= {};", value(i))]).collect();
        table(indent, &rows)
    };
    let next = |i: usize| plan.read(infos[i].next).to_string();
    let reset = |i: usize| {
        let width = plan.module().signal(infos[i].signal).width;
        match infos[i].reset.unwrap_or(0) {
            0 if width > 1 => "'0".to_string(),
            value => constant(width, value),
        }
    };
    let mut lines = Vec::new();
    let condition = enable.map(|enable| format!("if ({enable}) begin"));
    if infos[0].reset.is_some() {
        lines.push("  always_ff @(posedge clk_i or negedge rst_ni) begin".to_string());
        lines.push("    if (!rst_ni) begin".to_string());
        lines.extend(assignments("      ", &reset));
        lines.push(format!("    end else {}", condition.as_deref().unwrap_or("begin")));
        lines.extend(assignments("      ", &next));
        lines.push("    end".to_string());
    } else {
        lines.push("  always_ff @(posedge clk_i) begin".to_string());
        match condition {
            None => lines.extend(assignments("    ", &next)),
            Some(condition) => {
                lines.push(format!("    {condition}"));
                lines.extend(assignments("      ", &next));
                lines.push("    end".to_string());
            }
        }
    }
    lines.push("  end".to_string());
    lines
}

/// One bit that reads all of `ids`.
fn unused(plan: &Plan<'_>, ids: &[SignalId]) -> String {
    match ids {
        [] => "1'b0".to_string(),
        [one] if plan.module().signal(*one).width == 1 => plan.read(*one).to_string(),
        // Braces but around a name or part of it: `^~` would be another operator.
        [one] if !plan.read(*one).contains([' ', '~', '|', '&']) => format!("^{}", plan.read(*one)),
        _ => format!("^{{{}}}", ids.iter().map(|&id| plan.read(id)).collect::<Vec<_>>().join(", ")),
    }
}
