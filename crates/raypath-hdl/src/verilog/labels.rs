//! Labels of cases, as local parameters of the module.

use super::expression::constant;
use super::layout::{range, table};
use crate::netlist::{Driver, Module};
use std::collections::{BTreeSet, HashSet};

/// The labels that a module uses, each once, by width and value.
pub struct Labels<'m> {
    entries: Vec<(u32, u64, &'m str)>,
}

impl<'m> Labels<'m> {
    /// Collects the labels of the signals for which `printed` holds, and reserves their names among those `taken`.
    pub fn new(module: &'m Module, printed: impl Fn(usize) -> bool, taken: &mut HashSet<String>) -> Self {
        let mut entries = BTreeSet::new();
        for (_, signal) in module.signals().iter().enumerate().filter(|(index, _)| printed(*index)) {
            let Driver::Case { selector, arms, .. } = &signal.driver else { continue };
            let width = module.signal(*selector).width;
            entries.extend(arms.iter().map(|arm| (width, arm.label.value, arm.label.name.as_str())));
        }
        taken.extend(entries.iter().map(|(.., name)| name.to_string()));
        Self { entries: entries.into_iter().collect() }
    }

    /// Their declarations, after a blank line; nothing if there are none.
    pub fn declarations(&self) -> Vec<String> {
        let row = |&(width, value, name): &(u32, u64, &str)| {
            let parameter = "localparam logic".to_string();
            [parameter, range(width), name.to_string(), format!("= {};", constant(width, value))]
        };
        let rows: Vec<_> = self.entries.iter().map(row).collect();
        let blank = (!rows.is_empty()).then(String::new);
        blank.into_iter().chain(table("  ", &rows)).collect()
    }
}
