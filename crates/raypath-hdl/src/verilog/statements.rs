//! Statements as text.

use super::entries::{Entry, is_case};
use super::expression::constant;
use super::gate::CLOCK_GATE;
use super::layout::{COLUMNS, fill, table, wrap};
use super::plan::Plan;
use super::ram::RAM;
use crate::netlist::{Arm, Column, Driver, Instance, Module, SignalId, gate_instance, gated_clock};
use crate::text::{Bank, PortGroup};
use std::collections::HashMap;

/// The statements of a section: assignments in columns, blocks with blank lines around them.
pub fn print(plan: &Plan<'_>, entries: &[Entry<'_>]) -> Vec<String> {
    let mut text = Text::default();
    for entry in entries {
        match entry {
            Entry::Signal(id) => text.drive(plan, plan.read(*id), *id),
            Entry::Cases(group) => {
                let targets: Vec<_> = group.iter().map(|&id| (plan.read(id), id)).collect();
                text.block(cases(plan, &targets));
            }
            Entry::Instance(index) => text.block(instance(plan, *index)),
            Entry::Memory(index) => text.block(memory(plan, *index)),
            Entry::Registers(group) => text.block(registers(plan, group)),
            Entry::Unused(name, ids) => text.assign(name, unused(plan, ids)),
            Entry::Bank(bank, next) => {
                text.block(next_values(plan, next));
                text.block(bank_instance(plan, bank));
            }
            Entry::Output(index) if plan.is_connected(*index) => {}
            Entry::Output(index) => {
                let port = &plan.module().outputs()[*index];
                let group = plan.module().text().output.as_ref().filter(|group| group.contains(&port.name));
                match group {
                    // A structure is assigned as a whole, because a field of an enumeration takes no vector.
                    Some(group) if group.begins_with(&port.name) => text.assign(&group.name, whole(plan, group)),
                    Some(_) => {}
                    None if plan.is_renamed(port.signal) => text.drive(plan, &port.name, port.signal),
                    None => text.assign(&port.name, plan.read(port.signal).to_string()),
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

    /// Assigns the driver of a signal to `target`.
    fn drive(&mut self, plan: &Plan<'_>, target: &str, id: SignalId) {
        let driver = plan.driven_by(id);
        if is_case(plan.module(), driver) {
            self.block(cases(plan, &[(target, driver)]));
        } else {
            self.assign(target, plan.expression(id));
        }
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

/// One block with the next values of a bank of registers.
fn next_values(plan: &Plan<'_>, entries: &[Entry<'_>]) -> Vec<String> {
    let assignments = entries.iter().filter_map(|entry| match entry {
        Entry::Signal(id) => Some([plan.read(*id).to_string(), format!("= {};", plan.expression(*id))]),
        _ => None,
    });
    let mut lines = vec!["  always_comb begin".to_string()];
    lines.extend(table("    ", &assignments.collect::<Vec<_>>()));
    for entry in entries {
        if let Entry::Cases(group) = entry {
            let targets: Vec<_> = group.iter().map(|&id| (plan.read(id), id)).collect();
            lines.extend(case(plan, &targets));
        }
    }
    lines.push("  end".to_string());
    lines
}

/// A block with one `case`.
fn cases(plan: &Plan<'_>, targets: &[(&str, SignalId)]) -> Vec<String> {
    [vec!["  always_comb begin".to_string()], case(plan, targets), vec!["  end".to_string()]].concat()
}

/// One `case` that drives all `targets`, which share a selector and labels. It is not `unique`, because that has no
/// effect beside a default, and slang reports it. It lists all labels of an enumeration, because slang reports missing
/// ones.
fn case(plan: &Plan<'_>, targets: &[(&str, SignalId)]) -> Vec<String> {
    let alternatives = |id: SignalId| match &plan.module().signal(id).driver {
        Driver::Case { selector, arms, default } => Some((*selector, arms.as_slice(), *default)),
        _ => None,
    };
    let targets: Vec<(&str, SignalId, &[Arm], SignalId)> = targets
        .iter()
        .filter_map(|&(name, id)| alternatives(id).map(|(selector, arms, default)| (name, selector, arms, default)))
        .collect();
    let Some(&(_, selector, labels, _)) = targets.first() else { return Vec::new() };
    let mut rows: Vec<(Vec<String>, Vec<SignalId>)> = Vec::new();
    for (place, arm) in labels.iter().enumerate() {
        let values: Vec<SignalId> = targets.iter().map(|(_, _, arms, _)| arms[place].value).collect();
        let label = plan.labels().read(&arm.label.name);
        match rows.last_mut() {
            Some((row, last)) if *last == values => row.push(label),
            _ => rows.push((vec![label], values)),
        }
    }
    let defaults: Vec<SignalId> = targets.iter().map(|(.., default)| *default).collect();
    let others = plan.labels().others(labels);
    if !others.is_empty() {
        match rows.iter_mut().find(|(_, values)| *values == defaults) {
            Some((row, _)) => row.extend(others),
            None => rows.push((others, defaults.clone())),
        }
    }
    rows.push((vec!["default".to_string()], defaults));
    let rows: Vec<(String, Vec<SignalId>)> =
        rows.into_iter().map(|(labels, values)| (labels.join(", "), values)).collect();

    let mut lines = vec![format!("    case ({})", plan.read(selector))];
    let assignments = |values: &[SignalId]| -> Vec<[String; 2]> {
        let assignment = |((target, ..), &value): (&(&str, _, _, _), &SignalId)| {
            [target.to_string(), format!("= {};", plan.read(value))]
        };
        targets.iter().zip(values).map(assignment).collect()
    };
    let row = |(label, values): &(String, Vec<SignalId>)| [format!("{label}:"), assignments(values).concat().join(" ")];
    let short = (targets.len() == 1).then(|| table("      ", &rows.iter().map(row).collect::<Vec<_>>()));
    if let Some(short) = short.filter(|lines| lines.iter().all(|line| line.len() <= COLUMNS)) {
        lines.extend(short);
    } else {
        for (label, values) in &rows {
            lines.push(format!("      {label}: begin"));
            lines.extend(table("        ", &assignments(values)));
            lines.push("      end".to_string());
        }
    }
    lines.push("    endcase".to_string());
    lines
}

fn instance(plan: &Plan<'_>, index: usize) -> Vec<String> {
    let instance = &plan.module().instances()[index];
    let inside = &instance.module;
    let mut connections = Connections::new(inside);
    if let Some(template) = &inside.text().template {
        let ports = inside.inputs().iter().zip(&instance.inputs).chain(inside.outputs().iter().zip(&instance.outputs));
        let nets: HashMap<&str, SignalId> = ports.map(|(port, &id)| (port.name.as_str(), id)).collect();
        for (port, members) in &template.ports {
            let ids = members.iter().filter_map(|member| nets.get(member.as_str()).copied());
            connections.add(port, &joined(plan, &ids.collect::<Vec<_>>()));
        }
        let values = template.parameters.iter().map(|(name, value)| format!(".{name} ({value})"));
        let values = values.collect::<Vec<_>>().join(", ");
        return connections.print(&format!("{} #({values}) {}", template.module, instance.name));
    }
    let (groups, output) = (&inside.text().inputs, inside.text().output());
    let of_input = |port: &str| groups.iter().find(|group| group.contains(port));
    let inputs = inside.inputs().iter().zip(&instance.inputs).map(|(port, id)| (port, id, of_input(&port.name)));
    let outputs = inside.outputs().iter().zip(&instance.outputs).map(|(port, id)| (port, id, output));
    for (port, &id, group) in inputs.chain(outputs) {
        match group.filter(|group| group.contains(&port.name)) {
            None => connections.add(&port.name, plan.read(id)),
            Some(group) if group.begins_with(&port.name) => {
                let variable = plan.structures().of_instance(index).filter(|_| Some(group) == output);
                let net = variable.map_or_else(|| structure(plan, group, instance), str::to_string);
                connections.add(&group.name, &net);
            }
            Some(_) => {}
        }
    }
    connections.print(&format!("{} {}", inside.name(), instance.name))
}

/// The connection of input ports that form a structure: a whole structure, or its parts.
fn structure(plan: &Plan<'_>, group: &PortGroup, instance: &Instance) -> String {
    let inputs = instance.module.inputs().iter().zip(&instance.inputs);
    let by_port: HashMap<&str, SignalId> = inputs.map(|(port, &id)| (port.name.as_str(), id)).collect();
    let signals: Vec<SignalId> =
        group.members.iter().filter_map(|(port, _)| by_port.get(port.as_str()).copied()).collect();
    plan.structures().whole(plan.module(), group, &signals).unwrap_or_else(|| {
        let parts: Vec<&str> = signals.iter().map(|&id| plan.read(id)).collect();
        format!("{{{}}}", parts.join(", "))
    })
}

/// The output ports that form a structure.
fn whole(plan: &Plan<'_>, group: &PortGroup) -> String {
    let outputs = plan.module().outputs();
    let of = |(name, _): &(String, String)| outputs.iter().find(|port| port.name == *name);
    let parts: Vec<&str> = group.members.iter().filter_map(of).map(|port| plan.read(port.signal)).collect();
    format!("{{{}}}", parts.join(", "))
}

/// The instance that holds a bank of registers.
fn bank_instance(plan: &Plan<'_>, bank: &Bank) -> Vec<String> {
    let next = plan.structures().next();
    let mut connections = Connections::new(&bank.module);
    for port in bank.module.inputs().iter().chain(bank.module.outputs()) {
        match bank.ports.iter().find(|(name, _)| *name == port.name) {
            Some((_, id)) => connections.add(&port.name, plan.read(*id)),
            None if port.name == "data_i" => connections.add("data_i", next),
            None if port.name == "data_o" => connections.add("data_o", &bank.output.name),
            None => {}
        }
    }
    connections.print(&format!("{} #(.Width ($bits({next}))) {}", bank.module.name(), bank.name))
}

/// Signals as one net.
fn joined(plan: &Plan<'_>, ids: &[SignalId]) -> String {
    match ids {
        [one] => plan.read(*one).to_string(),
        _ => format!("{{{}}}", ids.iter().map(|&id| plan.read(id)).collect::<Vec<_>>().join(", ")),
    }
}

/// The instance of a memory.
fn memory(plan: &Plan<'_>, index: usize) -> Vec<String> {
    let memory = &plan.module().memories()[index];
    let joined = |of: fn(&Column) -> SignalId| joined(plan, &memory.columns.iter().map(of).collect::<Vec<_>>());
    let mut connections = Connections { items: vec![".clk_i".to_string()] };
    connections.add("write_enable_i", plan.read(memory.write_enable));
    connections.add("write_address_i", plan.read(memory.write_address));
    connections.add("write_data_i", &joined(|column| column.written));
    connections.add("read_enable_i", plan.read(memory.read_enable));
    connections.add("read_address_i", plan.read(memory.read_address));
    connections.add("read_data_o", &joined(|column| column.read));
    let width: u32 = memory.columns.iter().map(|column| plan.module().signal(column.read).width).sum();
    let latency = if memory.latency > 1 { format!(", .ReadLatency ({})", memory.latency) } else { String::new() };
    connections.print(&format!("{RAM} #(.Depth ({}), .Width ({width}){latency}) {}", memory.depth, memory.name))
}

/// The connections of an instance.
#[derive(Debug, Default)]
pub struct Connections {
    items: Vec<String>,
}

impl Connections {
    fn new(inside: &Module) -> Self {
        let clock = [("clk_i", inside.is_clocked()), ("rst_ni", inside.has_reset())];
        let items = clock.iter().filter(|(_, is_there)| *is_there).map(|(name, _)| format!(".{name}")).collect();
        Self { items }
    }

    /// Connects a net to a port.
    pub fn add(&mut self, port: &str, net: &str) {
        self.items.push(if port == net { format!(".{port}") } else { format!(".{port} ({net})") });
    }

    /// The lines of an instance: one if it fits, otherwise full ones.
    pub fn print(self, instance: &str) -> Vec<String> {
        let line = format!("  {instance} ({});", self.items.join(", "));
        if line.len() <= COLUMNS {
            return vec![line];
        }
        let last = self.items.len().saturating_sub(1);
        let items = self.items.into_iter().enumerate();
        let items: Vec<String> =
            items.map(|(place, item)| if place < last { format!("{item},") } else { item }).collect();
        let mut lines = vec![format!("  {instance} (")];
        lines.extend(fill("    ", &items));
        lines.push("  );".to_string());
        lines
    }
}

/// Whether a block of registers has the first of those behind its clock gate. The text has the gate before it.
pub fn begins_gate(module: &Module, group: &[usize]) -> bool {
    let info = |index: usize| &module.registers()[index];
    let is_of_gate = |index: usize| info(index).gated && info(index).enable == info(group[0]).enable;
    (0..module.registers().len()).find(|&index| is_of_gate(index)).is_some_and(|first| group.contains(&first))
}

/// Registers that share their enable or their gated clock, and either all have a reset or none.
fn registers(plan: &Plan<'_>, group: &[usize]) -> Vec<String> {
    let infos: Vec<_> = group.iter().map(|&index| &plan.module().registers()[index]).collect();
    let enable = infos[0].enable.filter(|_| !infos[0].gated).map(|id| plan.read(id));
    let gated = infos[0].enable.filter(|_| infos[0].gated);
    let gated = gated.and_then(|id| Some((id, plan.module().signal(id).name.as_deref()?)));
    let clock = gated.map_or("clk_i".to_string(), |(_, enable)| gated_clock(enable));
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
    if let Some((id, enable)) = gated.filter(|_| begins_gate(plan.module(), group)) {
        let mut connections = Connections { items: vec![".clk_i".to_string()] };
        connections.add("enable_i", plan.read(id));
        connections.add("clk_o", &clock);
        lines.extend(connections.print(&format!("{CLOCK_GATE} {}", gate_instance(enable))));
        lines.push(String::new());
    }
    let condition = enable.map(|enable| format!("if ({enable}) begin"));
    let mut body = Vec::new();
    if infos[0].reset.is_some() {
        lines.push(format!("  always_ff @(posedge {clock} or negedge rst_ni) begin"));
        body.push("    if (!rst_ni) begin".to_string());
        body.extend(assignments("      ", &reset));
        body.push(format!("    end else {}", condition.as_deref().unwrap_or("begin")));
    } else {
        lines.push(format!("  always_ff @(posedge {clock}) begin"));
        body.extend(condition.iter().map(|condition| format!("    {condition}")));
    }
    body.extend(assignments(if body.is_empty() { "    " } else { "      " }, &next));
    body.extend((body.len() > infos.len()).then(|| "    end".to_string()));
    lines.extend(in_short(body));
    lines.push("  end".to_string());
    lines
}

/// The lines of conditions with an assignment each, or of others. If they fit, each condition is on the line of its
/// assignment.
fn in_short(lines: Vec<String>) -> Vec<String> {
    let short = lines.chunks_exact(2).map(|pair| {
        let condition = pair[0].trim_start().trim_start_matches("end ").strip_suffix("begin")?;
        Some(format!("    {condition}{}", pair[1].trim_start())).filter(|line| line.len() <= COLUMNS)
    });
    let short: Option<Vec<String>> = short.collect();
    short.filter(|short| lines.len() > 1 && 2 * short.len() + 1 == lines.len()).unwrap_or(lines)
}

/// One bit that reads all of `ids`.
fn unused(plan: &Plan<'_>, ids: &[SignalId]) -> String {
    match ids {
        [] => "1'b0".to_string(),
        [one] if plan.module().signal(*one).width == 1 => plan.read(*one).to_string(),
        // Names and selects need no braces; others do, because `^~` is another operator.
        [one] if !plan.read(*one).contains([' ', '~', '|', '&']) => format!("^{}", plan.read(*one)),
        _ => format!("^{{{}}}", ids.iter().map(|&id| plan.read(id)).collect::<Vec<_>>().join(", ")),
    }
}
