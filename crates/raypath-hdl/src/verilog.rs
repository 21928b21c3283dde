//! Prints a netlist as SystemVerilog in the style of lowRISC.
//!
//! The text of a module follows its sections. A section declares what it defines, or reads from further down; then
//! come its assignments and instances in the order of building, and at its end its registers. Expressions without a
//! name are written inside their only reader while they stay short, and get a name after that reader otherwise.

mod entries;
mod expression;
mod labels;
mod layout;
mod plan;
mod statements;

use crate::netlist::{Module, Port};
use crate::{Error, SignalId};
use entries::{Chunk, Entry};
use layout::{comment, range, table};
use plan::Plan;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// The SystemVerilog text of one module, without those that it instantiates; see [`modules`]. The lines of `banner`
/// become its head comment, followed by the module's own.
pub fn print_module(module: &Module, banner: &[String]) -> Result<String, Error> {
    let plan = Plan::new(module);
    let mut lines = head_comment(module, banner);
    lines.extend(ports(module));
    lines.extend(plan.labels().declarations());
    let mut declared = HashSet::new();
    for chunk in plan.chunks() {
        lines.extend(section(&plan, chunk, &mut declared));
    }
    lines.extend([String::new(), format!("endmodule : {}", module.name())]);
    Ok(lines.into_iter().map(|line| line + "\n").collect())
}

/// `top` and every module below it, each once, those that are instantiated before those that instantiate them.
/// Different modules of one name are an error.
pub fn modules(top: &Arc<Module>) -> Result<Vec<Arc<Module>>, Error> {
    let mut found = Found::default();
    found.visit(top)?;
    Ok(found.order)
}

#[derive(Default)]
struct Found {
    order: Vec<Arc<Module>>,
    visited: HashSet<*const Module>,
    by_name: HashMap<String, Arc<Module>>,
}

impl Found {
    fn visit(&mut self, module: &Arc<Module>) -> Result<(), Error> {
        if !self.visited.insert(Arc::as_ptr(module)) {
            return Ok(());
        }
        for instance in module.instances() {
            self.visit(&instance.module)?;
        }
        match self.by_name.get(module.name()) {
            None => {
                self.by_name.insert(module.name().to_string(), module.clone());
                self.order.push(module.clone());
                Ok(())
            }
            // Built twice, alike: one text serves both. What they instantiate has been compared before.
            Some(other) if print_module(other, &[])? == print_module(module, &[])? => Ok(()),
            Some(_) => Err(Error::Name {
                module: module.name().to_string(),
                name: module.name().to_string(),
                problem: "is the name of two different modules".to_string(),
            }),
        }
    }
}

fn head_comment(module: &Module, banner: &[String]) -> Vec<String> {
    let mut lines: Vec<String> = banner.iter().flat_map(|text| text.split('\n')).map(comment).collect();
    if !banner.is_empty() && !module.doc().is_empty() {
        lines.push(comment(""));
    }
    lines.extend(module.doc().iter().flat_map(|text| text.split('\n')).map(comment));
    if !lines.is_empty() {
        lines.push(String::new());
    }
    lines
}

fn ports(module: &Module) -> Vec<String> {
    let mut rows: Vec<[String; 5]> = Vec::new();
    let mut row = |direction: &str, width: u32, name: &str, remark: &Option<String>| {
        let remark = remark.as_deref().map(layout::remark).unwrap_or_default();
        rows.push([direction.to_string(), "logic".to_string(), range(width), format!("{name},"), remark]);
    };
    for (name, present) in [("clk_i", module.is_clocked()), ("rst_ni", module.has_reset())] {
        if present {
            row("input", 1, name, &None);
        }
    }
    for port in module.inputs() {
        let signal = module.signal(port.signal);
        row("input", signal.width, &port.name, &signal.comment);
    }
    for port in module.outputs() {
        row("output", module.signal(port.signal).width, &port.name, &output_remark(module, port));
    }
    match rows.last_mut() {
        None => return vec![format!("module {};", module.name())],
        Some(last) => last[3].truncate(last[3].len() - 1),
    }
    let mut lines = vec![format!("module {} (", module.name())];
    lines.extend(table("  ", &rows));
    lines.push(");".to_string());
    lines
}

/// A named signal has its remark beside its own declaration.
fn output_remark(module: &Module, port: &Port) -> Option<String> {
    let signal = module.signal(port.signal);
    if signal.name.is_none() { signal.comment.clone() } else { None }
}

fn section(plan: &Plan<'_>, chunk: &Chunk<'_>, declared: &mut HashSet<SignalId>) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(title) = chunk.title {
        lines.extend([String::new(), layout::title(title)]);
    }
    let untitled = chunk.title.is_none();
    let declarations = declarations(plan, chunk, declared);
    if !declarations.is_empty() {
        lines.extend(untitled.then(String::new));
        lines.extend_from_slice(&declarations);
    }
    let statements = statements::print(plan, &chunk.entries);
    if !statements.is_empty() {
        lines.extend((untitled || !declarations.is_empty()).then(String::new));
        lines.extend(statements);
    }
    lines
}

/// What the section defines, or is the first to read, unless it is a port: every tool then sees a declaration before
/// its use.
fn declarations(plan: &Plan<'_>, chunk: &Chunk<'_>, declared: &mut HashSet<SignalId>) -> Vec<String> {
    let mut new: Vec<SignalId> =
        chunk.entries.iter().flat_map(|e| plan.mentioned(e)).filter(|&id| declared.insert(id)).collect();
    new.sort();
    let mut rows: Vec<[String; 4]> = Vec::new();
    for id in new {
        if let Some(name) = plan.declaration(id) {
            let signal = plan.module().signal(id);
            // A nameless signal that only drives this one has no declaration of its own to stand beside.
            let driver = plan.module().signal(plan.driven_by(id));
            let remark = signal.comment.as_ref().or(driver.comment.as_ref());
            let remark = remark.map(|remark| layout::remark(remark)).unwrap_or_default();
            rows.push(["logic".to_string(), range(signal.width), format!("{name};"), remark]);
        }
    }
    for entry in &chunk.entries {
        if let Entry::Unused(name, _) = entry {
            rows.push(["logic".to_string(), String::new(), format!("{name};"), String::new()]);
        }
    }
    table("  ", &rows)
}
