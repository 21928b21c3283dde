//! The result of a search, as JSON, a table and a page.

use super::metric::{Goal, Metric};
use super::predictor::Candidate;
use super::search::{Found, Outcome, Search, Status};
use crate::tables::{aligned, area_cells, path_cells, summary};
use crate::{Report, Setting};
use raypath_rtl::report::tables::table;
use serde::Serialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// The result of a search.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SearchReport {
    /// The goals.
    pub goals: Vec<Goal>,
    /// The metrics of the front.
    pub objectives: Vec<Metric>,
    /// The tools, the library and the period.
    pub setting: Setting,
    /// Whether no configuration is open.
    pub is_finished: bool,
    /// The number of measured configurations.
    pub measured: usize,
    /// The number of fits.
    pub rounds: usize,
    /// Combinations that the configuration refuses: their number by reason.
    pub refused: BTreeMap<String, usize>,
    /// For each metric the predictions within their stated errors, and all that were compared with a measurement.
    pub within_errors: BTreeMap<Metric, (usize, usize)>,
    /// All configurations of the space.
    pub points: Vec<SearchPoint>,
}

/// A configuration of the space.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SearchPoint {
    /// Its name.
    pub name: String,
    /// The command-line options for it.
    pub options: String,
    /// What is known of it.
    #[serde(flatten)]
    pub found: Found,
    /// Its measurement.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub report: Option<Report>,
}

impl SearchReport {
    /// The report of a search. `reports` are the measurements by candidate.
    pub fn new(
        search: &Search<'_>,
        outcome: Outcome,
        mut reports: BTreeMap<usize, Report>,
        setting: Setting,
        refused: BTreeMap<String, usize>,
    ) -> Self {
        let metrics = search.measured_metrics().into_iter();
        let within_errors = metrics.map(|metric| (metric, outcome.within_errors(metric))).collect();
        let (measured, rounds) = (outcome.measured(), outcome.rounds);
        let is_finished = outcome.with(Status::Open).is_empty();
        let candidates = search.candidates.iter().zip(outcome.found).enumerate();
        let points = candidates.map(|(place, (Candidate { name, options, .. }, found))| SearchPoint {
            name: name.clone(),
            options: options.clone(),
            found,
            report: reports.remove(&place),
        });
        Self {
            goals: search.goals.to_vec(),
            objectives: search.objectives.to_vec(),
            setting,
            is_finished,
            measured,
            rounds,
            refused,
            within_errors,
            points: points.collect(),
        }
    }

    /// The configurations on the front, by the first objective.
    pub fn front(&self) -> Vec<&SearchPoint> {
        let mut front: Vec<&SearchPoint> =
            self.points.iter().filter(|point| point.found.status == Status::Front).collect();
        let costs = |point: &SearchPoint| -> Vec<f64> {
            let cost = |metric: &Metric| metric.cost(point.found.values.get(metric).copied().unwrap_or(0.0));
            self.objectives.iter().map(cost).collect()
        };
        front.sort_by(|a, b| costs(a).partial_cmp(&costs(b)).unwrap_or(std::cmp::Ordering::Equal));
        front
    }

    /// A table of the front, whose configurations are named by their options.
    pub fn table(&self) -> String {
        let metrics: Vec<Metric> = Metric::ALL.into_iter().filter(|metric| self.has(*metric)).collect();
        let head = ["options"].into_iter().chain(metrics.iter().map(|metric| metric.unit()));
        let rows = self.front().into_iter().map(|point| {
            let values = metrics
                .iter()
                .map(|metric| point.found.values.get(metric).map(|value| metric.shown(*value)).unwrap_or_default());
            let options = if point.options.is_empty() { "the default" } else { &point.options };
            [options.to_string()].into_iter().chain(values)
        });
        aligned(table(head, rows), 1)
    }

    /// Whether a configuration has a value of the metric.
    fn has(&self, metric: Metric) -> bool {
        self.points.iter().any(|point| point.found.values.contains_key(&metric))
    }

    fn count(&self, status: Status) -> usize {
        self.points.iter().filter(|point| point.found.status == status).count()
    }

    /// The numbers of configurations, in lines of text.
    pub fn summary(&self) -> String {
        let objectives = self.objectives.iter().map(|metric| metric.name()).collect::<Vec<_>>().join(", ");
        let goals = self.goals.iter().map(Goal::to_string).collect::<Vec<_>>().join("; ");
        let refused: usize = self.refused.values().sum();
        let mut lines = vec![
            format!("Front of {objectives}. Goals: {}.", if goals.is_empty() { "none" } else { &goals }),
            format!(
                "{} configurations: {} measured, of which {} are on the front, {} dominated and {} miss a goal; {} not \
                 measured because of their predictions, and {} because of a goal for an exact metric.",
                self.points.len(),
                self.measured,
                self.count(Status::Front),
                self.count(Status::Dominated),
                self.count(Status::Missed),
                self.count(Status::Predicted),
                self.count(Status::Excluded)
            ),
        ];
        if refused > 0 {
            lines.push(format!("{refused} more combinations are no configurations:"));
            lines.extend(self.refused.iter().map(|(reason, count)| format!("  {count}: {reason}")));
        }
        for (metric, (within, all)) in self.within_errors.iter().filter(|(_, (_, all))| *all > 0) {
            lines.push(format!("Predicted {metric}: {within} of {all} within the stated error of 95 %."));
        }
        if !self.is_finished {
            let open = self.count(Status::Open);
            lines.push(format!("Not finished: {open} more may be on the front. The same command goes on from here."));
        }
        lines.join("\n")
    }

    /// The result as one self-contained HTML page: a diagram of two metrics, and the stages of each configuration.
    pub fn page(&self) -> String {
        let metrics = Metric::ALL.into_iter().filter(|metric| self.has(*metric)).map(
            |metric| json!({ "name": metric.name(), "unit": metric.unit(), "isMaximised": metric.is_maximised() }),
        );
        let data = json!({
            "summary": self.summary().lines().collect::<Vec<_>>(),
            "setting": format!(
                "{}, {}, library {}, gates chosen for {}",
                self.setting.synthesis,
                self.setting.timing,
                self.setting.library,
                self.setting.periods()
            ),
            "metrics": metrics.collect::<Vec<_>>(),
            "goals": self.goals,
            "points": self.points.iter().map(point).collect::<Vec<_>>(),
        });
        // `<` begins an element or a comment.
        let data = data.to_string().replace('<', "\\u003c");
        include_str!("page/page.html")
            .replace("/* page.css */", include_str!("page/page.css"))
            .replace("/* page.js */", include_str!("page/page.js"))
            .replace("/* data */", &data)
    }
}

/// A configuration for the script of the page. Only measured ones have tables.
fn point(point: &SearchPoint) -> Value {
    let SearchPoint { name, options, found, report } = point;
    let shown = |(metric, value): (&Metric, &f64)| (metric.name().to_string(), Value::String(metric.shown(*value)));
    let texts: serde_json::Map<String, Value> = found.values.iter().map(shown).collect();
    let grid =
        |title: &str, cells: crate::tables::Cells| json!({ "title": title, "head": cells.head, "rows": cells.rows });
    let tables = report.as_ref().map(|report| {
        [
            grid("Area by stage and kind, µm²", area_cells(report)),
            grid("The slowest path to each stage", path_cells(report)),
        ]
    });
    json!({
        "name": name, "options": options, "status": found.status, "values": found.values, "texts": texts,
        "predicted": found.predicted, "tables": tables, "summary": report.as_ref().map(summary),
    })
}
