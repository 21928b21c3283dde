//! Measurements of several configurations.

use crate::Report;
use serde::Serialize;

/// The measured configurations of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Exploration {
    /// In the order of the sweep.
    pub points: Vec<DesignPoint>,
}

/// A measured configuration with its throughput.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DesignPoint {
    /// A preset's name, or what differs from the default.
    pub name: String,
    /// The command-line options for it.
    pub options: String,
    /// Box tests per second at the reported clock: a job per cycle, four boxes per job.
    pub boxes_per_second: f64,
    /// Dimensions of Euclidean distances per second at the reported clock: a beat per cycle; 0 without distance modes.
    pub dimensions_per_second: f64,
    /// The measurement.
    pub report: Report,
}

/// Boxes per job.
const BOXES: f64 = 4.0;

impl DesignPoint {
    /// A configuration with this number of Euclidean lanes (0 without distance modes), and its measurement.
    pub fn new(name: impl Into<String>, options: impl Into<String>, lanes: usize, report: Report) -> Self {
        let cycles = report.clock_mhz * 1e6;
        Self {
            name: name.into(),
            options: options.into(),
            boxes_per_second: cycles * BOXES,
            dimensions_per_second: cycles * lanes as f64,
            report,
        }
    }
}
