//! The parameters of the hardware for searches.

use std::fmt;
use std::str::FromStr;

/// What the unit has for searches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SearchParameters {
    /// Searches at a time: 2 to 16.
    pub contexts: u32,
    /// The most neighbours that a job asks for: 1 to 64.
    pub neighbours: u32,
    /// The most candidates that a job keeps: `neighbours` to 256.
    pub candidates: u32,
    /// The most dimensions of vectors: 16 to 4096.
    pub dimensions: u32,
    /// Blocks that are fetched or wait for the datapath: 16 to 512, a power of two.
    pub blocks: u32,
    /// Indices that a search remembers, so that it does not compare their vectors again: 64 to 4096, a power of two.
    pub remembered: u32,
    /// Beats between two jobs of rays, if both wait for the datapath: 1 to 8.
    pub turns: u32,
    /// 1 if jobs search in trees of keys and of boxes, for which the datapath has two more operations; else 0.
    pub trees: u32,
}

/// The searches of a unit, if it has them. As text: `none`, or the parameters that differ from the default by name, such
/// as `k=32,m=64`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Searches(pub Option<SearchParameters>);

/// The error of a text that is none of [`Searches`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{0}', expected {expected}", expected = Searches::expected())]
pub struct ParseSearchesError(String);

/// A parameter: its name in texts, how it is reached, its least and greatest value, and whether it is a power of two.
type Named = (&'static str, fn(&mut SearchParameters) -> &mut u32, u32, u32, bool);

const NAMES: [Named; 8] = [
    ("k", |parameters| &mut parameters.neighbours, 1, 64, false),
    ("m", |parameters| &mut parameters.candidates, 1, 256, false),
    ("contexts", |parameters| &mut parameters.contexts, 2, 16, false),
    ("dimensions", |parameters| &mut parameters.dimensions, 16, 4096, false),
    ("blocks", |parameters| &mut parameters.blocks, 16, 512, true),
    ("remembered", |parameters| &mut parameters.remembered, 64, 4096, true),
    ("turns", |parameters| &mut parameters.turns, 1, 8, false),
    ("trees", |parameters| &mut parameters.trees, 0, 1, false),
];

impl Searches {
    /// The accepted texts, in words.
    pub fn expected() -> String {
        let range = |(name, _, least, most, is_power): &Named| {
            format!("{name}={least} to {most}{}", if *is_power { ", a power of two" } else { "" })
        };
        let ranges: Vec<String> = NAMES.iter().map(range).collect();
        format!("none or, separated by commas, some of: {}; m at least k", ranges.join("; "))
    }
}

impl fmt::Display for Searches {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(mut parameters) = self.0 else { return f.write_str("none") };
        for (place, (name, field, ..)) in NAMES.iter().enumerate() {
            write!(f, "{}{name}={}", if place > 0 { "," } else { "" }, field(&mut parameters))?;
        }
        Ok(())
    }
}

impl FromStr for Searches {
    type Err = ParseSearchesError;

    fn from_str(text: &str) -> Result<Self, ParseSearchesError> {
        let error = || ParseSearchesError(text.to_string());
        if text == "none" {
            return Ok(Self(None));
        }
        let mut parameters = SearchParameters::default();
        for part in text.split(',') {
            let (name, value) = part.split_once('=').ok_or_else(error)?;
            let (_, field, ..) = NAMES.iter().find(|(known, ..)| *known == name).ok_or_else(error)?;
            *field(&mut parameters) = value.parse().map_err(|_| error())?;
        }
        let is_valid = |(_, field, least, most, is_power): &Named| {
            let value = *field(&mut { parameters });
            (*least..=*most).contains(&value) && (!is_power || value.is_power_of_two())
        };
        let holds = NAMES.iter().all(is_valid) && parameters.candidates >= parameters.neighbours;
        if holds { Ok(Self(Some(parameters))) } else { Err(error()) }
    }
}

impl SearchParameters {
    /// The most of everything.
    pub const MOST: Self = Self {
        contexts: 16,
        neighbours: 64,
        candidates: 256,
        dimensions: 4096,
        blocks: 512,
        remembered: 4096,
        turns: 1,
        trees: 1,
    };

    /// Whether jobs search in trees.
    pub fn has_trees(&self) -> bool {
        self.trees > 0
    }
}

impl Default for SearchParameters {
    fn default() -> Self {
        Self {
            contexts: 8,
            neighbours: 32,
            candidates: 64,
            dimensions: 1024,
            blocks: 128,
            remembered: 1024,
            turns: 1,
            trees: 0,
        }
    }
}

impl fmt::Display for SearchParameters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { contexts, neighbours, candidates, dimensions, blocks, remembered, turns, trees: _ } = self;
        write!(
            f,
            "{contexts} searches of up to {neighbours} neighbours, {candidates} candidates and {dimensions} dimensions, \
             {blocks} blocks, {remembered} remembered indices, {turns} beats a job{}",
            if self.has_trees() { ", trees" } else { "" }
        )
    }
}
