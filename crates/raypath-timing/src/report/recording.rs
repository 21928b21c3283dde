use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

/// The content of a report. It is plain data, which serialises to JSON and back.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Recording {
    /// The title of the report.
    pub title: String,
    /// The configuration as pairs of name and value.
    pub configuration: Vec<(String, String)>,
    /// Counts and rates as pairs of label and formatted value.
    pub counts: Vec<(String, String)>,
    /// The names of the operations by opcode; empty for an unused opcode.
    pub operations: Vec<String>,
    /// The utilisation of each stage. If empty, the page has no heat map.
    pub utilisation: Vec<StageUse>,
    /// The recorded jobs. If there are none, the page has no timeline.
    pub window: Window,
    /// The rendered picture, if the run made one.
    pub image: Option<Image>,
    /// A plot of throughput over agents in flight and memory latency, as SVG.
    pub sweep: Option<String>,
    /// Further tables, such as the recall of a search.
    pub tables: Vec<Table>,
}

/// The utilisation of the units of one stage.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct StageUse {
    /// The number of the stage, from 1.
    pub number: usize,
    /// A short description of what each operation computes in the stage, by opcode; empty if it computes nothing.
    pub titles: Vec<String>,
    /// The units of the stage, by kind.
    pub units: Vec<UnitUse>,
}

/// The utilisation of the units of one kind in one stage.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct UnitUse {
    /// The name of the kind, such as `adder`.
    pub name: String,
    /// The number of units.
    pub count: usize,
    /// The fraction of unit cycles with work, 0 to 1.
    pub total: f64,
    /// The fraction of unit cycles with work for each operation, by opcode.
    pub by_operation: Vec<f64>,
}

/// Recorded jobs with their positions in the pipeline, and the stalls at its ports meanwhile.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Window {
    /// The name of a job's owner, such as `ray`.
    pub owner: String,
    /// The first recorded cycle.
    pub first: u64,
    /// The cycle after the last recorded one.
    pub end: u64,
    /// The number of stages.
    pub stages: usize,
    /// The jobs in the order of acceptance.
    pub jobs: Vec<JobTrace>,
    /// Cycles in which a job was offered and not accepted.
    pub refused: Vec<Span>,
    /// Cycles in which the output was valid and the sink not ready.
    pub stalled: Vec<Span>,
}

/// The positions of a job over time.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct JobTrace {
    /// The opcode.
    pub operation: usize,
    /// The number of the ray, query or transaction that it belongs to.
    pub owner: u64,
    /// The cycle of acceptance.
    pub accepted: u64,
    /// The first cycle in each stage that the job reached, from stage 1.
    pub entered: Vec<u64>,
    /// The cycle in which the sink took the outcome; `None` if that was not recorded.
    pub left: Option<u64>,
}

/// Consecutive cycles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Span {
    /// The first cycle.
    pub from: u64,
    /// The number of cycles.
    pub cycles: u64,
}

/// A picture for the report.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Image {
    /// The caption.
    pub title: String,
    /// The content of a PNG file; base64 in JSON.
    #[serde(serialize_with = "to_base64", deserialize_with = "from_base64")]
    pub png: Vec<u8>,
}

/// A table for the report.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Table {
    /// The caption.
    pub title: String,
    /// The column headings, with units.
    pub head: Vec<String>,
    /// The rows, formatted.
    pub rows: Vec<Vec<String>>,
}

impl Recording {
    /// The used opcodes and the names of their operations.
    pub(crate) fn named_operations(&self) -> impl Iterator<Item = (usize, &String)> {
        self.operations.iter().enumerate().filter(|(_, name)| !name.is_empty())
    }
}

impl JobTrace {
    /// The cycles in each stage that the job reached, as pairs of the first cycle and the one after the last. The last
    /// stage of a job without a recorded exit lasts until `end`.
    pub fn stays(&self, end: u64) -> impl Iterator<Item = (u64, u64)> + '_ {
        let over = self.left.map_or(end, |left| left + 1);
        let until = self.entered.iter().skip(1).copied().chain([over]);
        self.entered.iter().copied().zip(until)
    }

    /// The number of cycles in which the job did not advance; `end` as for [`stays`](Self::stays).
    pub fn stalls(&self, end: u64) -> u64 {
        self.stays(end).map(|(from, until)| until.saturating_sub(from + 1)).sum()
    }
}

fn to_base64<S: Serializer>(png: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&BASE64_STANDARD.encode(png))
}

fn from_base64<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<u8>, D::Error> {
    let text = String::deserialize(deserializer)?;
    BASE64_STANDARD.decode(text).map_err(de::Error::custom)
}
