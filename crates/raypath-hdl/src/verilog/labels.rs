//! Named constants: labels of cases, and parameters.

use super::expression::constant;
use super::layout::{range, table, wrap};
use crate::formula::Formula;
use crate::netlist::{Arm, Driver, Item, Module, SignalId};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

/// The named constants of a module: those of its package with the package's name, the others as local parameters.
pub struct Labels<'m> {
    module: &'m Module,
    /// By width and value, each once.
    local: BTreeSet<(u32, u64, &'m str)>,
    formulas: HashMap<&'m str, &'m Formula>,
    constants: HashSet<SignalId>,
}

impl<'m> Labels<'m> {
    /// Collects the constants of the signals for which `is_printed` holds, and reserves their names among those
    /// `taken`.
    pub fn new(module: &'m Module, is_printed: impl Fn(SignalId) -> bool, taken: &mut HashSet<String>) -> Self {
        let constants = named_constants(module);
        let mut labels = Self { module, local: BTreeSet::new(), formulas: HashMap::new(), constants };
        let package = module.text().package.as_ref();
        let local = &mut labels.local;
        let mut add = |width: u32, value: u64, name: &'m str| {
            if package.is_none_or(|package| package.label(name).is_none()) {
                local.insert((width, value, name));
            }
        };
        for (index, signal) in module.signals().iter().enumerate() {
            let id = SignalId(index as u32);
            match (&signal.driver, &signal.name) {
                (Driver::Case { selector, arms, .. }, _) if is_printed(id) => {
                    let width = module.signal(*selector).width;
                    arms.iter().for_each(|arm| add(width, arm.label.value, &arm.label.name));
                }
                (Driver::Constant(value), Some(name)) if labels.constants.contains(&id) && is_printed(id) => {
                    add(signal.width, *value, name);
                }
                _ => {}
            }
        }
        labels.formulas.extend(module.items().iter().filter_map(|item| match item {
            Item::Parameter(id, formula) => Some((module.signal(*id).name.as_deref()?, formula)),
            _ => None,
        }));
        taken.extend(labels.local.iter().map(|(.., name)| name.to_string()));
        labels
    }

    /// The text of a constant.
    pub fn read(&self, name: &str) -> String {
        let package = self.module.text().package.as_ref();
        package.and_then(|package| package.label(name)).unwrap_or_else(|| name.to_string())
    }

    /// Whether a signal is a label or a parameter.
    pub fn has(&self, id: SignalId) -> bool {
        self.constants.contains(&id)
    }

    /// The labels without an arm of their own of the package's enumeration that has those of the arms.
    pub fn others(&self, arms: &[Arm]) -> Vec<String> {
        let known = |name: &str| arms.iter().any(|arm| arm.label.name == name);
        let Some(package) = &self.module.text().package else { return Vec::new() };
        let enumeration = arms.iter().find_map(|arm| package.enumeration_of(&arm.label.name));
        let labels = enumeration.into_iter().flat_map(|enumeration| &enumeration.labels);
        labels.filter(|label| !known(&label.name)).filter_map(|label| package.label(&label.name)).collect()
    }

    /// The declarations, after a blank line; nothing if there are none.
    pub fn declarations(&self) -> Vec<String> {
        let formula = |value: u64, name: &str| {
            self.formulas.get(name).copied().filter(|formula| formula.value() == value && formula.is_derived())
        };
        let mut numbers: BTreeMap<&str, u64> = BTreeMap::new();
        for (_, value, name) in &self.local {
            let names = formula(*value, name).map(Formula::names).unwrap_or_default();
            numbers.extend(names.iter().map(|(name, value)| (name.as_str(), *value)));
        }
        let numbers = numbers
            .into_iter()
            .map(|(name, value)| [String::from("localparam logic [31:0]"), name.to_string(), format!("= {value};")]);
        let row = |&(width, value, name): &(u32, u64, &str)| {
            let value = match formula(value, name) {
                Some(formula) => format!("{width}'({})", formula.text()),
                None => constant(width, value),
            };
            let kind = format!("localparam logic {}", range(self.module, width));
            [kind.trim_end().to_string(), name.to_string(), format!("= {value};")]
        };
        let rows: Vec<_> = numbers.chain(self.local.iter().map(row)).collect();
        let blank = (!rows.is_empty()).then(String::new);
        blank.into_iter().chain(table("  ", &rows).into_iter().flat_map(wrap)).collect()
    }
}

/// Labels and parameters, but not wires that a constant drives.
fn named_constants(module: &Module) -> HashSet<SignalId> {
    let wires: HashSet<SignalId> = module
        .items()
        .iter()
        .filter_map(|item| match item {
            Item::Signal(id) => Some(*id),
            _ => None,
        })
        .collect();
    let is_constant = |id: &SignalId| {
        let signal = module.signal(*id);
        matches!(signal.driver, Driver::Constant(_)) && signal.name.is_some() && !wires.contains(id)
    };
    (0..module.signals().len() as u32).map(SignalId).filter(is_constant).collect()
}
