//! Many configurations beside each other.

use crate::ppa::Report;
use raypath_rtl::Config;
use serde::Serialize;

/// What a sweep found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Exploration {
    /// In the order of the sweep.
    pub points: Vec<Point>,
}

/// One configuration: its figures, and what it can do in a second.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Point {
    /// A preset's name, or what differs from the default.
    pub name: String,
    /// The options that ask for it.
    pub options: String,
    /// Box tests at that clock, four to a job and a job to a cycle.
    pub boxes_per_second: f64,
    /// Dimensions of Euclidean distances at that clock, a beat to a cycle; 0 without distance modes.
    pub dimensions_per_second: f64,
    /// The measurement.
    pub report: Report,
}

/// Boxes in a job.
const BOXES: f64 = 4.0;

impl Point {
    /// A configuration and its measurement.
    pub fn new(name: impl Into<String>, config: Config, report: Report) -> Self {
        let cycles = report.clock_mhz * 1e6;
        Self {
            name: name.into(),
            options: config.options(),
            boxes_per_second: cycles * BOXES,
            dimensions_per_second: cycles * config.semantics.lanes.count() as f64,
            report,
        }
    }
}
