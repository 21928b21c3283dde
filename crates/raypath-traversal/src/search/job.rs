//! A job of a search, and its layout in memory.

use super::distance::{Elements, VectorLayout};
use super::parameters::SearchParameters;
use thiserror::Error;

/// Bytes of a job: one block.
pub const JOB_BYTES: u32 = 64;

/// A search. All addresses are of the lower 32 bits; what they name begins at a multiple of 64 bytes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchJob {
    /// How vectors are compared.
    pub metric: SearchMetric,
    /// The elements of all vectors.
    pub elements: Elements,
    /// The number of dimensions, 1 to [`SearchParameters::dimensions`].
    pub dimensions: u32,
    /// The address of the query.
    pub query: u32,
    /// The address of vector 0.
    pub vectors: u32,
    /// The bytes from a vector to the next, a multiple of 64 and at least those of a vector.
    pub stride: u32,
    /// The number of vectors. Indices from here on name none, and are skipped.
    pub count: u32,
    /// The neighbours to return, 1 to [`SearchParameters::neighbours`]; fewer if there are no more.
    pub k: u32,
    /// Only vectors count whose rank is at most this: the squared distance of their elements, or minus their dot product
    /// or the cosine's monotone measure. The scale of integers is not in it.
    pub bound: f32,
    /// Where to look.
    pub place: Place,
}

/// How vectors are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SearchMetric {
    /// By the Euclidean distance; the nearest first.
    Euclidean,
    /// By the dot product; the greatest first.
    Dot,
    /// By the cosine of the angle; the greatest first.
    Cosine,
}

/// The vectors that a search compares with its query.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// All vectors.
    Scan,
    /// Those whose indices are in a list.
    Gather {
        /// The address of the list, words of 32 bits.
        list: u32,
        /// Its length.
        len: u32,
    },
    /// Those that a best-first search in a graph reaches.
    Graph {
        /// The address of the neighbours of vector 0: `degree` words of 32 bits, in whole blocks for each vector. A
        /// word that names no vector is skipped.
        neighbours: u32,
        /// The number of neighbours, 0 to 65,535.
        degree: u32,
        /// The address of the list of vectors to begin with.
        entries: u32,
        /// Its length.
        entry_count: u32,
        /// The candidates that are kept, `k` to [`SearchParameters::candidates`].
        candidates: u32,
        /// The most candidates whose neighbours are read.
        expansions: u32,
    },
    /// Those of a range of keys in a tree of [`NODE_BYTES`](super::NODE_BYTES) a node: `len` vectors, from the first of
    /// those behind all keys of leaves that are at most the key, which is word 3 of the query's block.
    Keys {
        /// The address of the root.
        nodes: u32,
        /// The vectors that are compared, 0 to 65,535.
        len: u32,
        /// The most nodes whose children are read.
        expansions: u32,
    },
    /// Those of the leaves of a tree of boxes in which the query is: its first three elements, 0 where it has fewer.
    Boxes {
        /// The address of the root.
        nodes: u32,
        /// The most nodes whose children are read.
        expansions: u32,
    },
}

/// A word of a job that the unit refuses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("word {word} of the job is {found:#x}, expected {expected}")]
pub struct JobError {
    /// The number of the word, from 0.
    pub word: usize,
    /// The word.
    pub found: u32,
    /// What is valid.
    pub expected: &'static str,
}

raypath_ops::names! {
    SearchMetric { Euclidean = "euclidean", Dot = "dot", Cosine = "cosine" },
    /// The error of an unknown name of a metric.
    ParseSearchMetricError, "metric `{0}`, expected euclidean, dot or cosine"
}

const METRICS: [SearchMetric; 3] = [SearchMetric::Euclidean, SearchMetric::Dot, SearchMetric::Cosine];

impl SearchMetric {
    /// Of the words of a job, which may be one that is refused.
    pub(crate) fn of_words(words: &[u32; 16]) -> Self {
        METRICS[(words[0] >> 4 & 3).min(2) as usize]
    }
}

impl SearchJob {
    /// The job as words of 32 bits, little-endian in memory.
    ///
    /// | word | bits | contents |
    /// |---|---|---|
    /// | 0 | 3:0, 7:4, 11:8, 31:16 | place (0 scan, 1 gather, 2 graph, 4 keys, 5 boxes), metric, elements, `k` |
    /// | 1 | 15:0, 31:16 | `dimensions`, `candidates` |
    /// | 2 to 5 | | `query`, `vectors`, `stride`, `count` |
    /// | 6, 7 | | `list`, `neighbours` or `nodes`; `len` or `degree` |
    /// | 8 to 10 | | `entries`, `entry_count`, `expansions` |
    /// | 11, 12 | | `bound` and the scale of integers, which is 1 for other elements, in binary32 |
    /// | 13 to 15 | | 0 |
    pub fn words(&self) -> [u32; 16] {
        let (place, list, len, graph) = match self.place {
            Place::Scan => (0, 0, 0, [0; 4]),
            Place::Gather { list, len } => (1, list, len, [0; 4]),
            Place::Graph { neighbours, degree, entries, entry_count, candidates, expansions } => {
                (2, neighbours, degree, [entries, entry_count, candidates, expansions])
            }
            Place::Keys { nodes, len, expansions } => (4, nodes, len, [0, 0, 0, expansions]),
            Place::Boxes { nodes, expansions } => (5, nodes, 0, [0, 0, 0, expansions]),
        };
        let metric = METRICS.iter().position(|metric| *metric == self.metric).unwrap_or(0) as u32;
        let [entries, entry_count, candidates, expansions] = graph;
        let mut words = [0; 16];
        words[0] = place | metric << 4 | self.elements.code() << 8 | self.k << 16;
        words[1] = self.dimensions | candidates << 16;
        words[2..6].copy_from_slice(&[self.query, self.vectors, self.stride, self.count]);
        words[6..11].copy_from_slice(&[list, len, entries, entry_count, expansions]);
        words[11..13].copy_from_slice(&[self.bound.to_bits(), self.elements.scale().to_bits()]);
        words
    }

    /// The layout of its vectors.
    pub fn layout(&self) -> VectorLayout {
        VectorLayout { elements: self.elements, dimensions: self.dimensions }
    }

    /// The candidates that it keeps.
    pub(super) fn kept(&self) -> u32 {
        if let Place::Graph { candidates, .. } = self.place { candidates } else { self.k }
    }

    /// The job of these words, in a unit of these parameters.
    ///
    /// # Errors
    /// A word that is outside its range.
    pub fn from_words(words: [u32; 16], parameters: &SearchParameters) -> Result<Self, JobError> {
        let refused = |word: usize, expected| JobError { word, found: words[word], expected };
        let is = |word, is_valid: bool, expected| if is_valid { Ok(()) } else { Err(refused(word, expected)) };
        let part = |word: usize, low: u32, bits: u32| words[word] >> low & ((1 << bits) - 1);
        let aligned = |word: usize| is(word, words[word].is_multiple_of(JOB_BYTES), "an address of whole blocks");
        let (place, k) = (part(0, 0, 4), words[0] >> 16);
        let is_tree = place & 4 != 0;
        let is_place = matches!(place, 0..=2) || (is_tree && place <= 5 && parameters.has_trees());
        is(0, is_place && part(0, 12, 4) == 0, "a place that the unit has and zeros in bits 15 to 12")?;
        is(0, (1..=parameters.neighbours).contains(&k), "1 to the unit's number of neighbours in bits 31 to 16")?;
        let metric = METRICS.get(part(0, 4, 4) as usize).copied();
        let metric = metric.ok_or(refused(0, "a metric of 0 to 2 in bits 7 to 4"))?;
        let elements = Elements::from_code(part(0, 8, 4), f32::from_bits(words[12]));
        let elements = elements.ok_or(refused(0, "elements of 0 to 2 in bits 11 to 8"))?;
        let (dimensions, candidates) = (part(1, 0, 16), words[1] >> 16);
        is(1, (1..=parameters.dimensions).contains(&dimensions), "1 to the unit's dimensions in bits 15 to 0")?;
        if is_tree {
            is(0, elements == Elements::Binary32, "elements in binary32 for a tree, 0 in bits 11 to 8")?;
            is(1, dimensions <= 3, "1 to 3 dimensions for a tree in bits 15 to 0")?;
        }
        (2..4).try_for_each(aligned)?;
        let least = VectorLayout { elements, dimensions }.bytes();
        is(4, words[4].is_multiple_of(JOB_BYTES) && words[4] >= least, "a multiple of 64 that holds a vector")?;
        let place = match place {
            0 => Place::Scan,
            1 => {
                aligned(6)?;
                Place::Gather { list: words[6], len: words[7] }
            }
            4.. => {
                aligned(6)?;
                let (nodes, len, expansions, are_keys) = (words[6], words[7], words[10], place == 4);
                let most = if are_keys { u16::MAX.into() } else { 0 };
                is(7, len <= most, "0 to 65535 vectors for keys, 0 for boxes")?;
                if are_keys { Place::Keys { nodes, len, expansions } } else { Place::Boxes { nodes, expansions } }
            }
            _ => {
                aligned(6)?;
                aligned(8)?;
                is(7, words[7] <= u16::MAX.into(), "a degree of 0 to 65535")?;
                is(
                    1,
                    (k..=parameters.candidates).contains(&candidates),
                    "as many candidates as neighbours to those of the unit, in bits 31 to 16",
                )?;
                Place::Graph {
                    neighbours: words[6],
                    degree: words[7],
                    entries: words[8],
                    entry_count: words[9],
                    candidates,
                    expansions: words[10],
                }
            }
        };
        is(11, !f32::from_bits(words[11]).is_nan(), "a number")?;
        let scale = f32::from_bits(words[12]);
        is(12, scale > 0.0 && scale.is_finite(), "a finite number above 0")?;
        (13..16).try_for_each(|word| is(word, words[word] == 0, "0"))?;
        let [query, vectors, stride, count] = [words[2], words[3], words[4], words[5]];
        let bound = f32::from_bits(words[11]);
        Ok(Self { metric, elements, dimensions, query, vectors, stride, count, k, bound, place })
    }
}
