//! The figures to compare a measurement with: an earlier measurement, or another design.

use crate::Slowest;
use raypath_tools::{ToolError, read_within};
use serde::Deserialize;
use std::path::Path;

/// The limit on a report, which has some hundred kilobytes.
const MAX_BYTES: u64 = 64 << 20;

/// The part of a `ppa.json` that a comparison needs. Only the total area, the flip-flops and the slowest path are
/// required, so that the figures of another design can be written by hand.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Baseline {
    /// The design's name.
    pub design: String,
    /// The area of the design, in the library's unit.
    pub area: BaselineArea,
    /// The number of flip-flops.
    pub flip_flops: u64,
    /// The slowest path of the design.
    pub slowest: Slowest,
    /// The stages, as far as known.
    #[serde(default)]
    pub stages: Vec<BaselineStage>,
}

/// A stage of a baseline.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct BaselineStage {
    /// The name, as in a report: `stage 3`.
    pub name: String,
    /// The area, if known.
    pub area: Option<BaselineArea>,
    /// The number of flip-flops, if known.
    pub flip_flops: Option<u64>,
    /// The slowest path, if known.
    pub slowest: Option<Slowest>,
}

/// The area of a baseline.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct BaselineArea {
    /// The sum of all kinds.
    pub total: f64,
}

impl Baseline {
    /// Reads the file `ppa.json` in a folder.
    ///
    /// # Errors
    /// The file cannot be read, is larger than 64 MiB, or is not a report.
    pub fn read(folder: &Path) -> Result<Self, ToolError> {
        let path = folder.join("ppa.json");
        Self::parse(&read_within(&path, MAX_BYTES)?, &path)
    }

    /// Parses the JSON of a report; `path` is for messages.
    ///
    /// # Errors
    /// The JSON is not a report.
    pub fn parse(json: &[u8], path: &Path) -> Result<Self, ToolError> {
        serde_json::from_slice(json).map_err(|problem| {
            ToolError::unexpected(
                &path.display().to_string(),
                problem.to_string(),
                "a report as `raypath ppa` writes it",
            )
        })
    }

    /// The stage of this name.
    pub fn stage(&self, name: &str) -> Option<&BaselineStage> {
        self.stages.iter().find(|stage| stage.name == name)
    }
}
