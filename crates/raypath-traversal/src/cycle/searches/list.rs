//! The best candidates of each search, sorted.

use super::Item;
use crate::hardware::{Burst, LIST_PER_WORD};
use crate::search::{SearchParameters, SearchStatus, key_of};
use raypath_model::{State, StateWords, state};

const PER_WORD: usize = LIST_PER_WORD as usize;

/// A candidate, in the order of the list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
struct Candidate {
    key: u32,
    index: u32,
    is_expanded: bool,
}

const NOTHING: Candidate = Candidate { key: u32::MAX, index: u32::MAX, is_expanded: false };

/// A neighbour, or the end.
#[derive(Debug, Clone, Copy, Default)]
pub struct Found {
    pub context: u8,
    pub key: u32,
    pub index: u32,
    /// At the end: how the search has ended.
    pub end: Option<SearchStatus>,
}

/// What happens at a clock edge.
#[derive(Debug, Clone, Copy, Default)]
pub struct ListEdge {
    /// What comes next can be taken.
    pub is_free: bool,
    pub found: Option<Found>,
    /// The search and the index whose neighbours come next.
    pub expands: Option<(u8, u32)>,
    /// A limit that changes.
    pub limit: Option<(u8, (u32, u32))>,
}

#[derive(Debug, Clone)]
pub struct List {
    work: Work,
    context: u8,
    failed: bool,
    words: usize,
    searches: Vec<Search>,
}

#[derive(Debug, Clone)]
struct Search {
    candidates: Vec<Candidate>,
    last_candidate: usize,
    last_neighbour: usize,
    is_refused: bool,
}

#[derive(Debug, Clone, Copy)]
enum Work {
    Idle,
    Clear { word: usize },
    Insert { word: usize, carried: Candidate },
    Seek { word: usize },
    Drain { place: usize, is_over: bool },
}

state! {
    Candidate { key, index, is_expanded }
    Found { context, key, index, end }
    List { work, context, failed, searches }
    Search { candidates, last_candidate, last_neighbour, is_refused }
}

impl State for SearchStatus {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        words.one_of(self, &[Self::Done, Self::Refused, Self::Memory]);
    }
}

impl State for Work {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        let mut kind = match self {
            Self::Idle => 0_u8,
            Self::Clear { .. } => 1,
            Self::Insert { .. } => 2,
            Self::Seek { .. } => 3,
            Self::Drain { .. } => 4,
        };
        let (mut number, mut carried, mut over) = match *self {
            Self::Idle => (0, NOTHING, false),
            Self::Clear { word } | Self::Seek { word } => (word, NOTHING, false),
            Self::Insert { word, carried } => (word, carried, false),
            Self::Drain { place, is_over } => (place, NOTHING, is_over),
        };
        kind.pass(words);
        number.pass(words);
        carried.pass(words);
        over.pass(words);
        *self = match kind {
            0 => Self::Idle,
            1 => Self::Clear { word: number },
            2 => Self::Insert { word: number, carried },
            3 => Self::Seek { word: number },
            4 => Self::Drain { place: number, is_over: over },
            _ => return words.refuse(),
        };
    }
}

impl List {
    pub fn new(parameters: SearchParameters) -> Self {
        let words = parameters.candidates.div_ceil(LIST_PER_WORD) as usize;
        let candidates = vec![NOTHING; words * PER_WORD];
        let search = Search { candidates, last_candidate: 0, last_neighbour: 0, is_refused: false };
        let searches = vec![search; parameters.contexts as usize];
        Self { work: Work::Idle, context: 0, failed: false, words, searches }
    }

    /// The clock edge of what is under way. A neighbour or the end leaves if `found_ready`.
    pub fn edge(&mut self, found_ready: bool) -> ListEdge {
        let context = self.context;
        let Search { candidates, last_candidate, last_neighbour, is_refused } =
            &mut self.searches[usize::from(context)];
        let last_word = *last_candidate / PER_WORD;
        let mut edge = ListEdge::default();
        match self.work {
            Work::Idle => edge.is_free = true,
            Work::Clear { word } => {
                candidates[word * PER_WORD..][..PER_WORD].fill(NOTHING);
                self.work = if word + 1 == self.words { Work::Idle } else { Work::Clear { word: word + 1 } };
            }
            Work::Insert { word, carried } => {
                let entries = &mut candidates[word * PER_WORD..][..PER_WORD];
                let order = |candidate: &Candidate| (candidate.key, candidate.index);
                let is_there = entries.iter().any(|other| order(other) == order(&carried));
                let place = entries.partition_point(|other| order(other) <= order(&carried));
                let mut behind = carried;
                if !is_there && place < PER_WORD {
                    behind = entries[PER_WORD - 1];
                    entries[place..].rotate_right(1);
                    entries[place] = carried;
                }
                let last = entries[PER_WORD - 1];
                if !is_there && word == last_word && last.key != NOTHING.key {
                    edge.limit = Some((context, (last.key, last.index)));
                }
                if !is_there && behind.key != NOTHING.key && word != last_word {
                    self.work = Work::Insert { word: word + 1, carried: behind };
                } else {
                    edge.is_free = is_there || word > 0;
                    self.work = Work::Idle;
                }
            }
            Work::Seek { word } => {
                let kept = &mut candidates[..=*last_candidate];
                let can_expand = |other: &&mut Candidate| other.key != NOTHING.key && !other.is_expanded;
                let mut entries = kept.iter_mut().skip(word * PER_WORD).take(PER_WORD);
                if let Some(candidate) = entries.find(can_expand) {
                    candidate.is_expanded = true;
                    edge.expands = Some((context, candidate.index));
                    self.work = Work::Idle;
                } else if word == last_word {
                    self.work = Work::Drain { place: 0, is_over: false };
                } else {
                    self.work = Work::Seek { word: word + 1 };
                }
            }
            Work::Drain { place, is_over } if found_ready => {
                let status = match (self.failed, *is_refused) {
                    (true, _) => SearchStatus::Memory,
                    (_, true) => SearchStatus::Refused,
                    _ => SearchStatus::Done,
                };
                let Candidate { key, index, .. } = candidates.get(place).copied().unwrap_or(NOTHING);
                let is_end = key == NOTHING.key || is_over || status != SearchStatus::Done;
                edge.found = Some(Found { context, key, index, end: is_end.then_some(status) });
                let next = Work::Drain { place: place + 1, is_over: place == *last_neighbour };
                self.work = if is_end { Work::Idle } else { next };
            }
            Work::Drain { .. } => {}
        }
        edge
    }

    /// A search begins. Returns its first limit.
    pub fn clear(&mut self, context: u8, words: &[u32; 16], is_refused: bool) -> (u32, u32) {
        self.context = context;
        self.work = Work::Clear { word: 0 };
        // As many bits as the hardware has: a job that is refused may have any words.
        let places = self.words.next_power_of_two().max(2) * PER_WORD;
        let last = |count: u32| (count as usize).wrapping_sub(1) % places;
        let neighbour = last(words[0] >> 16);
        let search = &mut self.searches[usize::from(context)];
        search.last_neighbour = neighbour;
        search.last_candidate = if words[0] & 2 != 0 { last(words[1] >> 16) } else { neighbour };
        search.is_refused = is_refused;
        // Of both zeros, this is the positive one.
        (key_of(f32::from_bits(words[11]) + 0.0), u32::MAX)
    }

    /// A vector or a marker is taken.
    pub fn take(&mut self, item: Item) {
        let Item { burst, context, index, key, failed } = item;
        (self.context, self.failed) = (context, failed);
        self.work = match burst {
            Burst::Vector => Work::Insert { word: 0, carried: Candidate { key, index, is_expanded: false } },
            Burst::Expand if !failed => Work::Seek { word: 0 },
            _ => Work::Drain { place: 0, is_over: false },
        };
    }
}
