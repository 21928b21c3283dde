//! What was measured, as a table and as JSON.

use crate::error::CliError;
use comfy_table::presets::ASCII_MARKDOWN;
use comfy_table::{CellAlignment, Table};
use serde::Serialize;
use std::fmt;

/// All that was measured.
#[derive(Debug, Default, Serialize)]
pub struct Results {
    /// Rates, each under a name that stays.
    rates: Vec<Rate>,
    /// How cost grows with what there is to do.
    growth: Vec<Growth>,
    /// What could not be measured, and why.
    missing: Vec<String>,
}

/// So many of something a second.
#[derive(Debug, Clone, Serialize)]
pub struct Rate {
    /// What was measured.
    pub what: String,
    /// What is counted: "jobs", "cycles".
    pub unit: &'static str,
    /// How many of them in a second.
    pub per_second: f64,
    /// What our goal is, if there is one.
    pub goal: Option<f64>,
    /// The rate of another program that did the same in this run, and its name.
    pub peer: Option<(String, f64)>,
}

/// Nanoseconds an item, for ever more items.
#[derive(Debug, Clone, Serialize)]
pub struct Growth {
    /// What was measured.
    pub what: String,
    /// How many items, and nanoseconds for each.
    pub points: Vec<(u64, f64)>,
}

impl Results {
    pub fn rate(&mut self, what: impl Into<String>, unit: &'static str, per_second: f64, goal: Option<f64>) {
        self.rates.push(Rate { what: what.into(), unit, per_second, goal, peer: None });
    }

    /// Names a peer's rate beside all rates that count `unit`.
    pub fn beside(&mut self, unit: &str, peer: &str, per_second: f64) {
        for rate in self.rates.iter_mut().filter(|rate| rate.unit == unit) {
            rate.peer = Some((peer.to_string(), per_second));
        }
    }

    pub fn growth(&mut self, what: impl Into<String>, points: Vec<(u64, f64)>) {
        self.growth.push(Growth { what: what.into(), points });
    }

    pub fn missing(&mut self, what: String) {
        self.missing.push(what);
    }

    pub fn json(&self) -> Result<String, CliError> {
        serde_json::to_string_pretty(self).map_err(CliError::unusable)
    }
}

impl fmt::Display for Results {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = Table::new();
        table.load_preset(ASCII_MARKDOWN);
        table.set_header(["what", "per second", "goal", "beside"]);
        for Rate { what, unit, per_second, goal, peer } in &self.rates {
            let goal = goal.map_or_else(String::new, |goal| format!("{}, x {:.2}", count(goal), per_second / goal));
            let beside = peer.as_ref().map_or_else(String::new, |(name, of_peer)| {
                format!("{} of {name}, x {:.2}", count(*of_peer), per_second / of_peer)
            });
            table.add_row([what.clone(), format!("{} {unit}", count(*per_second)), goal, beside]);
        }
        if let Some(column) = table.column_mut(1) {
            column.set_cell_alignment(CellAlignment::Right);
        }
        writeln!(f, "{table}")?;
        for Growth { what, points } in &self.growth {
            let points: Vec<String> = points.iter().map(|(items, ns)| format!("{items}: {ns:.2}")).collect();
            writeln!(f, "\n{what}, ns each, by how many: {}", points.join(", "))?;
        }
        for missing in &self.missing {
            writeln!(f, "\nnot measured: {missing}")?;
        }
        Ok(())
    }
}

/// Three digits and a unit.
fn count(number: f64) -> String {
    let (scale, name) = match number {
        n if n >= 1e9 => (1e9, " G"),
        n if n >= 1e6 => (1e6, " M"),
        n if n >= 1e3 => (1e3, " k"),
        _ => (1.0, ""),
    };
    let scaled = number / scale;
    let digits = if scaled >= 100.0 {
        0
    } else if scaled >= 10.0 {
        1
    } else {
        2
    };
    format!("{scaled:.digits$}{name}")
}
