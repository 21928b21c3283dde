//! The parameters of the hardware for searches.

use std::fmt;

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
}

impl SearchParameters {
    /// The most of everything.
    pub const MOST: Self =
        Self { contexts: 16, neighbours: 64, candidates: 256, dimensions: 4096, blocks: 512, remembered: 4096 };
}

impl Default for SearchParameters {
    fn default() -> Self {
        Self { contexts: 8, neighbours: 32, candidates: 64, dimensions: 1024, blocks: 128, remembered: 1024 }
    }
}

impl fmt::Display for SearchParameters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { contexts, neighbours, candidates, dimensions, blocks, remembered } = self;
        write!(
            f,
            "{contexts} searches of up to {neighbours} neighbours, {candidates} candidates and {dimensions} dimensions, \
             {blocks} blocks, {remembered} remembered indices"
        )
    }
}
