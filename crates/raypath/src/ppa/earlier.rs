//! Figures of an earlier measurement, or of somebody else's design.

use raypath_tools::{ToolError, read_within};
use serde::Deserialize;
use std::path::Path;

/// More than any report has: some hundred kilobytes.
const MOST_BYTES: u64 = 64 << 20;

/// What a comparison needs of a `ppa.json`. Only the whole area, the flip-flops and the slowest path must be there, so
/// that a design of other stages, or one that was measured otherwise, can be written down by hand.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Earlier {
    /// What was measured.
    pub design: String,
    /// Everything, in the library's unit.
    pub area: EarlierArea,
    /// All flip-flops.
    pub flip_flops: u64,
    /// The slowest path of all.
    pub slowest: EarlierPath,
    /// Its stages, as far as known.
    #[serde(default)]
    pub stages: Vec<EarlierStage>,
}

/// A stage of an earlier measurement.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct EarlierStage {
    /// As our reports name it: `stage 3`.
    pub name: String,
    /// Its area.
    pub area: Option<EarlierArea>,
    /// Its flip-flops.
    pub flip_flops: Option<u64>,
    /// Its slowest path.
    pub slowest: Option<EarlierPath>,
}

/// An area.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct EarlierArea {
    /// Of everything.
    pub total: f64,
}

/// A path.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct EarlierPath {
    /// Its length in nanoseconds.
    pub ns: f64,
}

impl Earlier {
    /// Reads `ppa.json` in a folder.
    ///
    /// # Errors
    /// It cannot be read, is larger than 64 MiB, or is no report.
    pub fn read(folder: &Path) -> Result<Self, ToolError> {
        let path = folder.join("ppa.json");
        Self::parse(&read_within(&path, MOST_BYTES)?, &path)
    }

    /// Reads the JSON of a report; `path` is for messages.
    ///
    /// # Errors
    /// It is no report.
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
    pub fn stage(&self, name: &str) -> Option<&EarlierStage> {
        self.stages.iter().find(|stage| stage.name == name)
    }
}
