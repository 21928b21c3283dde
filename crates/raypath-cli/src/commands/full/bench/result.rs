//! The results of measurements, as a table and as JSON.

use crate::error::CliError;
use comfy_table::presets::ASCII_MARKDOWN;
use comfy_table::{CellAlignment, Table};
use serde::Serialize;
use std::fmt;
use std::time::{Duration, Instant};

#[derive(Debug, Default, Serialize)]
pub struct Results {
    /// Rates. Their names are stable, so that runs can be compared.
    rates: Vec<Rate>,
    /// The growth of cost with the number of items.
    growth: Vec<Growth>,
    /// The measurements that failed, each with the reason.
    missing: Vec<String>,
}

#[derive(Debug, Clone, Serialize)]
pub struct Rate {
    pub what: String,
    /// The unit that is counted, for example "jobs" or "cycles".
    pub unit: &'static str,
    pub per_second: f64,
    pub goal: Option<f64>,
    /// Another program that did the same work in this run: its name and its rate.
    pub peer: Option<(String, f64)>,
}

/// The cost per item for growing numbers of items.
#[derive(Debug, Clone, Serialize)]
pub struct Growth {
    pub what: String,
    /// The number of items, and the nanoseconds per item.
    pub points: Vec<(u64, f64)>,
}

impl Results {
    pub fn rate(&mut self, what: impl Into<String>, unit: &'static str, per_second: f64, goal: Option<f64>) {
        self.rates.push(Rate { what: what.into(), unit, per_second, goal, peer: None });
    }

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
            writeln!(f, "\n{what}, ns per item by number of items: {}", points.join(", "))?;
        }
        for missing in &self.missing {
            writeln!(f, "\nnot measured: {missing}")?;
        }
        Ok(())
    }
}

/// A number with three digits and a prefix: `1.23 M`.
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

/// The minimum duration of a run: far longer than a read of the clock, and shorter than a time slice of the scheduler,
/// so that some runs are not interrupted.
const RUN: Duration = Duration::from_millis(1);

/// The seconds of a call of `work`, which does the same each time: the minimum of `repetitions` runs, each with as many
/// calls as last a millisecond.
pub fn seconds(repetitions: usize, mut work: impl FnMut()) -> f64 {
    let once = best(1, 1, &mut work);
    let calls = (RUN.as_secs_f64() / once.max(1e-9)).ceil().clamp(1.0, 1e6) as usize;
    best(repetitions.max(1), calls, &mut work)
}

fn best(repetitions: usize, calls: usize, work: &mut impl FnMut()) -> f64 {
    let run = |_| {
        let begin = Instant::now();
        (0..calls).for_each(|_| work());
        begin.elapsed().as_secs_f64() / calls as f64
    };
    (0..repetitions).map(run).fold(f64::INFINITY, f64::min)
}
