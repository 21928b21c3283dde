//! The distances of neighbours, and the channel of results.

use super::Fifo;
use super::list::Found;
use crate::engine::SearchResult;
use crate::hardware::{RESULTS_DIGITS, RESULTS_WAITING};
use crate::search::{Neighbour, SearchMetric, SearchParameters, SearchStatus, distance_of, rank_of_key};
use raypath_float::{DivSqrt, Format};
use raypath_model::state;

#[derive(Debug, Clone)]
pub struct Results {
    found: Fifo<Found>,
    count: u32,
    searches: Vec<Search>,
    /// The neighbour whose distance is computed or shown, and the cycles until it is known.
    busy: Option<(Found, u32)>,
    is_none: bool,
    number: u32,
}

#[derive(Debug, Clone, Copy)]
struct Search {
    id: u64,
    metric: SearchMetric,
    scale: f32,
    norm: f32,
}

state! {
    Results { found, count, searches, busy, is_none, number }
    Search { id, metric, scale, norm }
}

impl Results {
    pub fn new(parameters: SearchParameters) -> Self {
        let search = Search { id: 0, metric: SearchMetric::Euclidean, scale: 1.0, norm: 1.0 };
        let searches = vec![search; parameters.contexts as usize];
        Self { found: Fifo::new(), count: 0, searches, busy: None, is_none: false, number: 0 }
    }

    pub fn can_push(&self) -> bool {
        self.count < RESULTS_WAITING
    }

    pub fn enter(&mut self, context: u8, id: u64) {
        self.searches[usize::from(context)].id = id;
    }

    pub fn load(&mut self, context: u8, words: &[u32; 16]) {
        let search = &mut self.searches[usize::from(context)];
        (search.metric, search.scale) = (SearchMetric::of_words(words), f32::from_bits(words[12]));
    }

    pub fn norm(&mut self, context: u8, key: u32) {
        self.searches[usize::from(context)].norm = rank_of_key(key);
    }

    /// The result that is shown.
    pub fn shown(&self) -> Option<SearchResult> {
        let first = self.found.first();
        let end = first.and_then(|first| first.end);
        let (found, neighbour) = match self.busy {
            Some((found, 0)) if first.is_some() => (found, true),
            _ if self.is_none => (*first?, false),
            _ => return None,
        };
        let Search { id, metric, scale, norm } = self.searches[usize::from(found.context)];
        let distance = || distance_of(metric, rank_of_key(found.key), norm, scale);
        let neighbour = neighbour.then(|| Neighbour { index: found.index, distance: distance() });
        let status = end.unwrap_or(SearchStatus::Done);
        Some(SearchResult { id, rank: self.number, neighbour, status, is_last: end.is_some() })
    }

    /// The clock edge. Returns the search that is over.
    pub fn edge(&mut self, found: Option<Found>, ready: bool) -> Option<u8> {
        let shown = self.shown().filter(|_| ready);
        let first = self.found.first().copied();
        let is_end = first.is_some_and(|first| first.end.is_some());
        let take = first.filter(|_| !is_end && self.busy.is_none());
        let ends = shown.is_some_and(|shown| shown.is_last);
        let was_busy = self.busy.is_some();
        let pops = take.is_some() || ends;
        self.count = self.count + u32::from(found.is_some()) - u32::from(pops);
        let released = first.filter(|_| ends).map(|first| first.context);
        if shown.is_some() {
            self.number = if ends { 0 } else { self.number + 1 };
        }
        match (&mut self.busy, shown.is_some() && !self.is_none) {
            (busy, true) => *busy = None,
            (Some((_, left)), false) => *left = left.saturating_sub(1),
            (busy, false) => *busy = take.map(|found| (found, self.searches[usize::from(found.context)].cycles())),
        }
        self.is_none = ((is_end && !was_busy) || self.is_none) && !ends;
        self.found.edge(found, pops);
        released
    }
}

/// Cycles of a product.
const PRODUCT: u32 = 3;

impl Search {
    /// The cycles of its two operations.
    fn cycles(self) -> u32 {
        let divided = DivSqrt::iterative_latency(Format::BINARY32, RESULTS_DIGITS) + 1;
        match self.metric {
            SearchMetric::Euclidean => divided + PRODUCT,
            SearchMetric::Dot => 2 * PRODUCT,
            SearchMetric::Cosine => 2 * divided,
        }
    }
}
