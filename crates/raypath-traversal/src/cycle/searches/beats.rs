//! The beats of vectors, and where other blocks go.

use super::fetch::{Block, Entry};
use super::ranks::Sent;
use super::{Beat, Visited};
use crate::hardware::Burst;
use crate::search::{Branch, Elements, SearchMetric, SearchParameters, Shape, key_of, rank_of, sums};
use raypath_model::{State, StateWords, state};

#[derive(Debug, Clone)]
pub struct Beats {
    taken: Option<Taken>,
    /// A bit for each search of which a block has failed.
    failed: u32,
    shapes: Vec<Shape>,
    queries: Vec<Vec<f32>>,
    /// The elements so far of the vector whose blocks are taken, and whether they are sent.
    vector: Vec<f32>,
    /// The first words of the node whose blocks are taken.
    node: Vec<u32>,
    skips: bool,
    is_first_block: bool,
}

#[derive(Debug, Clone, Copy)]
struct Taken {
    entry: Entry,
    block: Block,
    has_failed: bool,
    /// The elements that are left.
    left: u32,
}

state! { Taken { entry, block, has_failed, left } }

impl State for Beats {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        let Self { taken, failed, shapes, queries, vector, node, skips, is_first_block } = self;
        taken.pass(words);
        failed.pass(words);
        shapes.pass(words);
        queries.iter_mut().for_each(|query| words.many(query));
        words.many(vector);
        words.many(node);
        skips.pass(words);
        is_first_block.pass(words);
    }
}

impl Default for Taken {
    fn default() -> Self {
        Self { entry: Entry::default(), block: [0; _], has_failed: false, left: 0 }
    }
}

impl State for Shape {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        self.metric.pass(words);
        words.one_of(&mut self.elements, &[Elements::Binary32, Elements::Binary16, Elements::Int8 { scale: 1.0 }]);
        self.tail.pass(words);
        self.is_keys.pass(words);
    }
}

impl State for SearchMetric {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        words.one_of(self, &[Self::Euclidean, Self::Dot, Self::Cosine]);
    }
}

impl Beats {
    pub fn new(parameters: SearchParameters) -> Self {
        let contexts = parameters.contexts as usize;
        Self {
            taken: None,
            failed: 0,
            shapes: vec![Shape::of_words(&[0; 16]); contexts],
            queries: vec![Vec::new(); contexts],
            vector: Vec::new(),
            node: Vec::new(),
            skips: false,
            is_first_block: true,
        }
    }

    /// Whether a block of this search has failed.
    pub fn has_failed(&self, context: u8) -> bool {
        self.failed >> context & 1 == 1
    }

    /// No more vectors of this search are sent.
    pub fn fail(&mut self, context: u8) {
        self.failed |= 1 << context;
    }

    fn fails(&self, taken: &Taken) -> bool {
        let before = taken.entry.burst != Burst::Job && self.has_failed(taken.entry.context);
        before || (!taken.entry.burst.is_marker() && taken.has_failed)
    }

    fn skips(&self, taken: &Taken) -> bool {
        taken.entry.burst.is_vector() && if self.is_first_block { self.fails(taken) } else { self.skips }
    }

    fn lanes(&self, taken: &Taken) -> u32 {
        self.shapes[usize::from(taken.entry.context)].lanes()
    }

    /// The beat that is offered.
    pub fn offer(&self, can_send: bool) -> Option<Beat> {
        if self.is_node_complete() {
            return self.taken.map(|taken| {
                let is_keys = self.shapes[usize::from(taken.entry.context)].is_keys;
                Beat { node: Some(is_keys), is_angular: false, is_last: false }
            });
        }
        let taken = self.taken.as_ref().filter(|taken| taken.entry.burst.is_vector() && !self.skips(taken))?;
        let lanes = self.lanes(taken);
        let is_last = taken.left <= lanes && taken.entry.is_last;
        (!is_last || can_send).then_some(Beat { node: None, is_angular: lanes == 8, is_last })
    }

    fn is_node_complete(&self) -> bool {
        self.taken.is_some_and(|Taken { entry, .. }| entry.burst == Burst::Node && entry.is_last)
    }

    /// The node that is offered.
    pub fn node(&self) -> Option<Visited> {
        let (Entry { context, index, .. }, second) = self.words(Burst::Node).filter(|(entry, _)| entry.is_last)?;
        let words = self.node.iter().copied().chain(second);
        let mut node = [0; 32];
        node.iter_mut().zip(words).for_each(|(to, from)| *to = from);
        let query = &self.queries[usize::from(context)];
        let query = std::array::from_fn(|k| query.get(k).copied().unwrap_or_default());
        let is_keys = self.shapes[usize::from(context)].is_keys;
        Some(Visited { context, branch: Branch::of_node(&node, query, is_keys), is_last: index & 1 == 1 })
    }

    /// The job that was taken: its context and words.
    pub fn job(&self) -> Option<(u8, [u32; 16])> {
        self.words(Burst::Job).map(|(entry, words)| (entry.context, words))
    }

    /// The block of a list that was taken: its context, its number and its words.
    pub fn list(&self) -> Option<(u8, u32, [u32; 16])> {
        self.words(Burst::List).map(|(entry, words)| (entry.context, entry.index, words))
    }

    fn words(&self, burst: Burst) -> Option<(Entry, [u32; 16])> {
        let Taken { entry, block, .. } = self.taken.as_ref().filter(|taken| taken.entry.burst == burst)?;
        let words = block.as_chunks::<4>().0;
        Some((*entry, std::array::from_fn(|k| words.get(k).map_or(0, |bytes| u32::from_le_bytes(*bytes)))))
    }

    /// What is sent with a beat that leaves, or as a marker, and whether what was taken has ended.
    pub fn ends(&self, leaves: bool, loads: bool, can_send: bool) -> (Option<Sent>, bool) {
        let Some(taken) = &self.taken else { return (None, false) };
        let Entry { burst, context, index, is_last } = taken.entry;
        let sent = |key, is_rank| Some(Sent { burst, context, index, failed: self.fails(taken), key, is_rank });
        match burst {
            Burst::Job => (None, loads),
            Burst::Query | Burst::List => (None, true),
            Burst::Node => (None, leaves || !is_last),
            Burst::Expand | Burst::Drain => (sent(0, false).filter(|_| can_send), can_send),
            Burst::Norm | Burst::Vector => {
                let is_end = taken.left <= self.lanes(taken);
                let (key, is_rank) = if leaves && is_end && is_last { self.rank(taken) } else { (0, false) };
                (sent(key, is_rank).filter(|_| leaves && is_end && is_last), self.skips(taken) || (leaves && is_end))
            }
        }
    }

    /// The key of the rank of a vector that is complete, or of the query's norm; and whether it has one.
    fn rank(&self, taken: &Taken) -> (u32, bool) {
        let context = usize::from(taken.entry.context);
        let Shape { metric, elements, tail, .. } = self.shapes[context];
        let len = self.vector.len() + tail as usize - elements.per_block() as usize;
        let query = self.queries[context].get(..len).unwrap_or_default();
        let (sums, _) = sums(metric, query, self.vector.get(..len).unwrap_or_default());
        let rank = if taken.entry.burst == Burst::Norm { sums.norm } else { rank_of(metric, sums) };
        (key_of(rank), !rank.is_nan())
    }

    pub fn is_free(&self, ended: bool) -> bool {
        self.taken.is_none() || ended
    }

    pub fn keeps_query(&self) -> bool {
        self.taken.as_ref().is_some_and(|taken| taken.entry.burst == Burst::Query)
    }

    /// The clock edge: a beat leaves, what was taken has ended, and the next block is taken.
    pub fn edge(&mut self, next: Option<(Entry, Block, bool)>, leaves: bool, ended: bool) {
        if let Some(taken) = self.taken {
            let (is_job, fails, skips) = (taken.entry.burst == Burst::Job, self.fails(&taken), self.skips(&taken));
            let bit = 1 << taken.entry.context;
            if is_job || fails {
                self.failed = if fails { self.failed | bit } else { self.failed & !bit };
            }
            if taken.entry.burst.is_vector() {
                self.skips = skips;
            }
            if ended {
                if taken.entry.burst.is_vector() || taken.entry.burst == Burst::Query {
                    self.is_first_block = taken.entry.is_last;
                }
                self.taken = None;
            } else if let (Some(taken), true) = (&mut self.taken, leaves) {
                taken.left -= self.shapes[usize::from(taken.entry.context)].lanes();
            }
        }
        if let Some((entry, block, has_failed)) = next {
            self.take(entry, block, has_failed);
        }
    }

    fn take(&mut self, entry: Entry, block: Block, has_failed: bool) {
        let context = usize::from(entry.context);
        let shape = self.shapes[context];
        let left = if entry.is_last { shape.tail } else { shape.elements.per_block() };
        self.taken = Some(Taken { entry, block, has_failed, left });
        match entry.burst {
            Burst::Job => {
                let words = self.job().map(|(_, words)| words).unwrap_or_default();
                self.shapes[context] = Shape::of_words(&words);
                self.queries[context].clear();
            }
            Burst::Query => self.queries[context].extend(shape.elements.of_block(&block)),
            Burst::Norm | Burst::Vector => {
                if self.is_first_block {
                    self.vector.clear();
                }
                self.vector.extend(shape.elements.of_block(&block));
            }
            Burst::Node if !entry.is_last => {
                self.node = self.words(Burst::Node).map(|(_, words)| words.to_vec()).unwrap_or_default();
            }
            Burst::Node | Burst::List | Burst::Expand | Burst::Drain => {}
        }
    }
}
