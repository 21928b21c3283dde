//! The modules of a design, and its text as files.

use super::gate::{CLOCK_GATE, CLOCK_GATE_DOC, CLOCK_GATE_TEXT};
use super::ram::{RAM, RAM_DOC, RAM_TEXT};
use super::{LICENSE, head, print_module, print_package};
use crate::Error;
use crate::netlist::Module;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// A package or a module as text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// The name of the package or module.
    pub name: String,
    /// Its text, with the licence, the banner and its own comment at the head.
    pub text: String,
}

/// The text of `top` and everything that it needs, in the order of compilation: the package, [`RAM`] if there is a
/// memory, [`CLOCK_GATE`] if there is one, then modules and [templates](crate::text::Template), those that are
/// instantiated before those that instantiate them. Each begins with the lines of `banner`.
///
/// # Errors
/// Different modules or packages of one name, or a module with the name of one of these cells.
pub fn sources(top: &Arc<Module>, banner: &[String]) -> Result<Vec<Source>, Error> {
    let mut found = Found { is_text: true, ..Found::default() };
    found.visit(top)?;
    let banner: Vec<String> = std::iter::once(LICENSE.to_string()).chain(banner.iter().cloned()).collect();
    let mut sources: Vec<Source> = Vec::new();
    for package in found.order.iter().filter_map(|module| module.text().package.as_ref()) {
        let source = Source { name: package.name.clone(), text: print_package(package, &banner) };
        match sources.iter().find(|other| other.name == source.name) {
            None => sources.push(source),
            Some(other) if *other == source => {}
            Some(_) => return Err(two_of_a_name(&source.name)),
        }
    }
    let has_memories = found.order.iter().any(|module| !module.memories.is_empty());
    let has_gates = found.order.iter().any(|module| module.gates().next().is_some());
    let cells = [(has_memories, RAM, RAM_DOC, RAM_TEXT), (has_gates, CLOCK_GATE, CLOCK_GATE_DOC, CLOCK_GATE_TEXT)];
    for (_, name, doc, text) in cells.into_iter().filter(|(is_used, ..)| *is_used) {
        if found.by_name.contains_key(name) {
            return Err(two_of_a_name(name));
        }
        sources.push(Source { name: name.to_string(), text: head(&banner[1..], &[doc.to_string()]) + text });
    }
    for module in &found.order {
        for [name, doc, text] in module.text().verbatim.iter().flat_map(|(_, below)| below) {
            let text = head(&banner[1..], std::slice::from_ref(doc)) + text;
            sources.push(Source { name: name.clone(), text });
        }
        let template = module.text().template.as_ref().filter(|_| !Arc::ptr_eq(module, top));
        let source = match template {
            None => Source { name: module.name().to_string(), text: print_module(module, &banner)? },
            Some(template) => {
                let text = head(&banner[1..], std::slice::from_ref(&template.doc)) + &template.text;
                Source { name: template.module.clone(), text }
            }
        };
        match sources.iter().find(|other| other.name == source.name) {
            None => sources.push(source),
            Some(other) if *other == source => {}
            Some(_) => return Err(two_of_a_name(&source.name)),
        }
    }
    Ok(sources)
}

/// The text of `top` and everything that it needs.
///
/// # Errors
/// Different modules or packages of one name.
pub fn text(top: &Arc<Module>) -> Result<String, Error> {
    Ok(sources(top, &[])?.into_iter().map(|source| source.text).collect())
}

/// `top` and every module below it in the netlist, each once, those that are instantiated before those that instantiate
/// them.
///
/// # Errors
/// Different modules of one name.
pub fn modules(top: &Arc<Module>) -> Result<Vec<Arc<Module>>, Error> {
    let mut found = Found::default();
    found.visit(top)?;
    Ok(found.order)
}

#[derive(Default)]
struct Found {
    /// Whether to find what the text instantiates, not the netlist.
    is_text: bool,
    order: Vec<Arc<Module>>,
    visited: HashSet<*const Module>,
    by_name: HashMap<String, Arc<Module>>,
}

impl Found {
    fn visit(&mut self, module: &Arc<Module>) -> Result<(), Error> {
        if !self.visited.insert(Arc::as_ptr(module)) {
            return Ok(());
        }
        let bank = module.text().bank.as_ref().filter(|_| self.is_text);
        if let Some(bank) = bank {
            self.visit(&bank.module)?;
        }
        // A template may have a loop in place of some instances.
        let template = module.text().template.as_ref().filter(|_| self.is_text);
        let is_there = |name: &str| template.is_none_or(|template| template.text.contains(&format!("{name} ")));
        for (index, instance) in module.instances().iter().enumerate() {
            if bank.is_none_or(|bank| bank.replaces != Some(index)) && is_there(instance.module.name()) {
                self.visit(&instance.module)?;
            }
        }
        match self.by_name.get(module.name()) {
            None => {
                self.by_name.insert(module.name().to_string(), module.clone());
                self.order.push(module.clone());
                Ok(())
            }
            // Built twice with one text. The modules that they instantiate have been compared before.
            Some(other) if print_module(other, &[])? == print_module(module, &[])? => Ok(()),
            Some(_) => Err(two_of_a_name(module.name())),
        }
    }
}

fn two_of_a_name(name: &str) -> Error {
    let problem = "is the name of two different modules".to_string();
    Error::Name { module: name.to_string(), name: name.to_string(), problem }
}
