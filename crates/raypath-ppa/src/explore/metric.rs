//! The metrics of a configuration, and goals for them.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// A metric of a configuration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Metric {
    /// The area of the cells in mm²; measured.
    Area,
    /// The slowest path in ns; measured.
    Period,
    /// The energy of a job of a picture in pJ; measured, only if asked for.
    Energy,
    /// Jobs per cycle; exact without measurement. More is better.
    Throughput,
    /// Visits of nodes and leaves added by boxes in fewer bits, in percent; exact without measurement.
    Visits,
    /// Cycles from a job to its outcome; exact without measurement.
    Latency,
}

/// The values of a configuration; a metric that is not known is absent.
pub type Values = BTreeMap<Metric, f64>;

impl Metric {
    /// All metrics.
    pub const ALL: [Self; 6] = [Self::Area, Self::Period, Self::Energy, Self::Throughput, Self::Visits, Self::Latency];

    /// Its unit in tables.
    pub fn unit(self) -> &'static str {
        ["mm²", "ns", "pJ per job", "jobs a cycle", "% more visits", "cycles"][self as usize]
    }

    /// Whether it is known only after synthesis.
    pub fn is_measured(self) -> bool {
        matches!(self, Self::Area | Self::Period | Self::Energy)
    }

    /// Whether a larger value is better.
    pub fn is_maximised(self) -> bool {
        self == Self::Throughput
    }

    /// A value for which less is better.
    pub(super) fn cost(self, value: f64) -> f64 {
        if self.is_maximised() { -value } else { value }
    }

    /// A value as text, without its unit.
    pub fn shown(self, value: f64) -> String {
        match self {
            Self::Area | Self::Throughput => format!("{value:.3}"),
            Self::Period | Self::Visits => format!("{value:.2}"),
            Self::Energy => format!("{value:.1}"),
            Self::Latency => format!("{value:.0}"),
        }
    }

    /// The units in which a goal may be written, and their values in the metric's unit.
    fn units(self) -> &'static [(&'static str, f64)] {
        match self {
            Self::Area => &[("mm2", 1.0), ("mm²", 1.0), ("um2", 1e-6), ("µm²", 1e-6)],
            Self::Period => &[("ns", 1.0), ("ps", 1e-3)],
            Self::Energy => &[("pJ", 1.0), ("nJ", 1e3)],
            Self::Visits => &[("%", 1.0)],
            Self::Throughput | Self::Latency => &[("", 1.0)],
        }
    }

    /// How a goal for it is written.
    fn example(self) -> &'static str {
        match self {
            Self::Area => "'area<=0.6mm2' or 'area<=600000um2'",
            Self::Period => "'period<=12ns'",
            Self::Energy => "'energy<=900pJ' (a job)",
            Self::Throughput => "'throughput>=0.5' (jobs a cycle)",
            Self::Visits => "'visits<=2%' (more than with rules paper)",
            Self::Latency => "'latency<=16' (cycles)",
        }
    }
}

raypath_ops::names! {
    Metric {
        Area = "area",
        Period = "period",
        Energy = "energy",
        Throughput = "throughput",
        Visits = "visits",
        Latency = "latency"
    },
    /// The error of a name that no metric has.
    ParseMetricError, "'{0}' is not a metric, expected area, period, energy, throughput, visits, latency"
}

/// A limit on a metric: at most, or for throughput at least.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Goal {
    /// The metric.
    pub metric: Metric,
    /// The limit, in the metric's unit.
    pub limit: f64,
}

impl Goal {
    /// Whether a value meets the goal.
    pub fn is_met(self, value: f64) -> bool {
        self.metric.cost(value) <= self.metric.cost(self.limit)
    }
}

/// As in `area<=0.6mm2`. Spaces may surround the parts.
impl FromStr for Goal {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let problem = |found: String, expected: String| Err(format!("'{text}': {found}, expected {expected}"));
        let Some(place) = text.find(['<', '>', '=']) else {
            return problem("no <= or >=".to_string(), format!("a goal like {}", Metric::Area.example()));
        };
        let metric: Metric = text[..place].trim().parse().map_err(|problem: ParseMetricError| problem.to_string())?;
        let relation = if metric.is_maximised() { ">=" } else { "<=" };
        let Some(value) = text[place..].strip_prefix(relation) else {
            return problem(format!("{metric} without {relation}"), metric.example().to_string());
        };
        let value = value.trim();
        let end = value.find(|c: char| !(c.is_ascii_digit() || ".eE+-".contains(c))).unwrap_or(value.len());
        let (number, unit) = (&value[..end], value[end..].trim());
        if value.is_empty() {
            return problem(format!("no number after {relation}"), metric.example().to_string());
        }
        // Without a digit, what stands there is no number with a unit.
        let found = if number.contains(|c: char| c.is_ascii_digit()) { number } else { value };
        let Some(number) = number.parse().ok().filter(|number: &f64| number.is_finite() && *number >= 0.0) else {
            return problem(format!("'{found}' is not a number from 0 on"), metric.example().to_string());
        };
        let Some((_, scale)) = metric.units().iter().find(|(name, _)| *name == unit) else {
            return problem(format!("'{unit}' is not its unit"), metric.example().to_string());
        };
        Ok(Self { metric, limit: number * scale })
    }
}

impl fmt::Display for Goal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let relation = if self.metric.is_maximised() { "at least" } else { "at most" };
        write!(f, "{} {relation} {} {}", self.metric, self.limit, self.metric.unit())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goals_have_units() {
        let goals = [
            ("area<=0.6mm2", Metric::Area, 0.6),
            (" area <= 600000 µm² ", Metric::Area, 0.6),
            ("period<=1.2e1ns", Metric::Period, 12.0),
            ("period<=500ps", Metric::Period, 0.5),
            ("energy<=1.5nJ", Metric::Energy, 1500.0),
            ("throughput>=0.5", Metric::Throughput, 0.5),
            ("visits<=2%", Metric::Visits, 2.0),
            ("latency<=16", Metric::Latency, 16.0),
        ];
        for (text, metric, limit) in goals {
            let goal: Goal = text.parse().expect(text);
            assert!(goal.metric == metric && (goal.limit - limit).abs() < 1e-9, "{text}: {goal:?}");
        }
    }

    #[test]
    fn wrong_goals_say_what_was_expected() {
        let wrong = [
            ("area", "no <= or >=, expected a goal like 'area<=0.6mm2'"),
            ("areas<=1mm2", "'areas' is not a metric, expected area, period, energy, throughput, visits, latency"),
            ("area<=0.6", "'' is not its unit, expected 'area<=0.6mm2'"),
            ("area<=0.6ns", "'ns' is not its unit, expected 'area<=0.6mm2'"),
            ("area>=0.6mm2", "area without <=, expected 'area<=0.6mm2'"),
            ("area<0.6mm2", "area without <=, expected"),
            ("throughput<=1", "throughput without >=, expected 'throughput>=0.5'"),
            ("period<=-1ns", "'-1' is not a number from 0 on, expected 'period<=12ns'"),
            ("period<=ns", "'ns' is not a number from 0 on, expected 'period<=12ns'"),
            ("area<=x", "'x' is not a number from 0 on, expected 'area<=0.6mm2'"),
            ("area<=eur", "'eur' is not a number from 0 on"),
            ("period<= ", "no number after <=, expected 'period<=12ns'"),
            ("visits<=1e999%", "'1e999' is not a number"),
        ];
        for (text, message) in wrong {
            let problem = text.parse::<Goal>().expect_err(text);
            assert!(problem.contains(message), "{text}: {problem}");
        }
    }

    #[test]
    fn limits_are_met_at_the_limit() {
        let goal = |text: &str| text.parse::<Goal>().expect("a goal");
        assert!(goal("area<=1mm2").is_met(1.0) && !goal("area<=1mm2").is_met(1.001));
        assert!(goal("throughput>=0.5").is_met(0.5) && !goal("throughput>=0.5").is_met(0.25));
        assert_eq!(goal("visits<=2%").to_string(), "visits at most 2 % more visits");
    }
}
