use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

/// All that a report shows: plain data, whoever has made it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Recording {
    /// What was run.
    pub title: String,
    /// What it was run on, as names and values.
    pub configuration: Vec<(String, String)>,
    /// Counts and rates, as labels and printed values.
    pub counts: Vec<(String, String)>,
    /// The operations' names, by opcode; empty where there is none of that opcode.
    pub operations: Vec<String>,
    /// How busy the units were, stage by stage; none is shown of an empty one.
    pub utilisation: Vec<StageUse>,
    /// Some jobs on their way through the pipeline.
    pub window: Window,
    /// What came out, if it is a picture.
    pub image: Option<Image>,
    /// Throughput by agents in flight and memory, as SVG.
    pub sweep: Option<String>,
    /// What else there is to say, for example a recall.
    pub tables: Vec<Table>,
}

/// How busy the units of one stage were.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct StageUse {
    /// The stage, from 1.
    pub number: usize,
    /// What each operation does in it, by opcode; empty where it does nothing.
    pub titles: Vec<String>,
    /// Its units, kind by kind.
    pub units: Vec<UnitUse>,
}

/// How busy the units of one kind in one stage were.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct UnitUse {
    /// The kind's name, as `adder`.
    pub name: String,
    /// How many there are.
    pub count: usize,
    /// The part of all unit cycles in which they worked, 0 to 1.
    pub total: f64,
    /// The same for each operation's jobs, by opcode.
    pub by_operation: Vec<f64>,
}

/// Some jobs on their way through the pipeline, and what happened at its ends meanwhile.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Window {
    /// What a job's owner is called, as `ray`.
    pub owner: String,
    /// The first cycle seen.
    pub first: u64,
    /// The cycle after the last one seen.
    pub end: u64,
    /// How many registers (or skid buffers) a job passes.
    pub stages: usize,
    /// The jobs, in the order in which they were accepted.
    pub jobs: Vec<JobTrace>,
    /// Cycles in which the source offered a job that was not accepted.
    pub refused: Vec<Span>,
    /// Cycles in which the sink refused an answer.
    pub stalled: Vec<Span>,
}

/// When a job was where.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct JobTrace {
    /// Its opcode.
    pub operation: usize,
    /// The number of the ray, query or transaction that it belongs to.
    pub owner: u64,
    /// The cycle in which it was accepted.
    pub accepted: u64,
    /// The first cycle in each stage that it has reached, from stage 1.
    pub entered: Vec<u64>,
    /// The cycle in which the sink took its answer; none if that was not seen.
    pub left: Option<u64>,
}

/// Cycles in a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Span {
    /// The first of them.
    pub from: u64,
    /// How many.
    pub cycles: u64,
}

/// A picture.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Image {
    /// What it shows.
    pub title: String,
    /// A PNG file; written as base64.
    #[serde(serialize_with = "to_base64", deserialize_with = "from_base64")]
    pub png: Vec<u8>,
}

/// A table.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Table {
    /// What it shows.
    pub title: String,
    /// The columns' heads, units included.
    pub head: Vec<String>,
    /// Its rows, printed.
    pub rows: Vec<Vec<String>>,
}

impl Recording {
    /// The operations that there are, with their opcodes.
    pub(crate) fn named_operations(&self) -> impl Iterator<Item = (usize, &String)> {
        self.operations.iter().enumerate().filter(|(_, name)| !name.is_empty())
    }
}

impl JobTrace {
    /// For each stage reached: the cycles it was there, first and one past the last. Of a job that has not been seen
    /// leaving, the last stage lasts to `end`.
    pub fn stays(&self, end: u64) -> impl Iterator<Item = (u64, u64)> + '_ {
        let over = self.left.map_or(end, |left| left + 1);
        let until = self.entered.iter().skip(1).copied().chain([over]);
        self.entered.iter().copied().zip(until)
    }

    /// Cycles at whose end it did not move on, in all stages; `end` as for [`stays`](Self::stays).
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
