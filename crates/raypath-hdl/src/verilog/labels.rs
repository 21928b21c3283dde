//! Labels of cases, as local parameters of the module.

use super::expression::constant;
use super::layout::{range, table};
use crate::Error;
use crate::names;
use crate::netlist::{Driver, Module};
use std::collections::HashSet;

/// The labels that a module uses, each once, in the order of first use.
pub struct Labels<'m> {
    entries: Vec<(&'m str, u32, u64)>,
}

impl<'m> Labels<'m> {
    /// Collects the labels of the signals for which `printed` holds, and reserves their names among those `taken`.
    pub fn new(
        module: &'m Module,
        printed: impl Fn(usize) -> bool,
        taken: &mut HashSet<String>,
    ) -> Result<Self, Error> {
        let fail = |name: &str, problem: String| {
            Err(Error::Name { module: module.name().to_string(), name: name.to_string(), problem })
        };
        let mut entries: Vec<(&str, u32, u64)> = Vec::new();
        for (_, signal) in module.signals().iter().enumerate().filter(|(index, _)| printed(*index)) {
            let Driver::Case { selector, arms, .. } = &signal.driver else { continue };
            let width = module.signal(*selector).width;
            for label in arms.iter().map(|arm| &arm.label) {
                match entries.iter().find(|(name, ..)| *name == label.name) {
                    Some((_, w, v)) if (*w, *v) == (width, label.value) => {}
                    Some((_, w, v)) => {
                        let (one, other) = (constant(*w, *v), constant(width, label.value));
                        return fail(&label.name, format!("labels both {one} and {other}"));
                    }
                    None => {
                        if let Some(problem) = names::problem(&label.name) {
                            return fail(&label.name, problem.to_string());
                        }
                        if !taken.insert(label.name.clone()) {
                            return fail(&label.name, "is taken".to_string());
                        }
                        entries.push((&label.name, width, label.value));
                    }
                }
            }
        }
        Ok(Self { entries })
    }

    /// Their declarations, after a blank line; nothing if there are none.
    pub fn declarations(&self) -> Vec<String> {
        let row = |&(name, width, value): &(&str, u32, u64)| {
            let parameter = "localparam logic".to_string();
            [parameter, range(width), name.to_string(), format!("= {};", constant(width, value))]
        };
        let rows: Vec<_> = self.entries.iter().map(row).collect();
        let blank = (!rows.is_empty()).then(String::new);
        blank.into_iter().chain(table("  ", &rows)).collect()
    }
}
