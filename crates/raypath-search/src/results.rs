use crate::metric::Metric;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// The result of a search with its cost.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchResults {
    /// The neighbours of each query, nearest first, and by index at equal distances.
    pub rows: Vec<Vec<Neighbour>>,
    /// The work of the datapath.
    pub work: Work,
    /// The wall-clock time of the search in seconds.
    pub seconds: f64,
}

/// A neighbour of a query, ordered by distance and then by index.
#[derive(Debug, Clone, Copy)]
pub struct Neighbour {
    /// The index of the vector in the base.
    pub index: u32,
    /// The distance: [`euclidean_distance`](crate::euclidean_distance) or [`cosine_distance`](crate::cosine_distance).
    pub distance: f64,
}

/// The work of the datapath.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Work {
    /// The number of evaluated pairs of vectors.
    pub evaluations: u64,
    /// The number of their beats.
    pub beats: u64,
}

impl Work {
    /// The work for a number of pairs of vectors.
    pub(crate) fn of(evaluations: u64, metric: Metric, dimensions: usize) -> Self {
        Self { evaluations, beats: evaluations.saturating_mul(metric.beats(dimensions)) }
    }
}

impl SearchResults {
    /// The results of these searches of different queries in one base, in their order. The times are added.
    pub fn joined(searches: impl IntoIterator<Item = Self>) -> Self {
        let mut all = Self { rows: Vec::new(), work: Work::default(), seconds: 0.0 };
        for search in searches {
            all.rows.extend(search.rows);
            all.work.evaluations += search.work.evaluations;
            all.work.beats += search.work.beats;
            all.seconds += search.seconds;
        }
        all
    }

    /// The number of completed queries per second.
    pub fn queries_per_second(&self) -> f64 {
        self.rows.len() as f64 / self.seconds
    }

    /// The mean per query of a total over all queries.
    pub fn per_query(&self, total: u64) -> f64 {
        total as f64 / self.rows.len().max(1) as f64
    }
}

/// The nearest of the candidates offered so far, by their distances or a monotonic function of these.
#[derive(Debug, Clone)]
pub(crate) struct Nearest {
    heap: BinaryHeap<Neighbour>,
    count: usize,
}

impl Nearest {
    pub(crate) fn new(count: usize) -> Self {
        Self { heap: BinaryHeap::with_capacity(count), count }
    }

    /// The distance of the farthest candidate; `None` while there are fewer than `count`.
    #[inline]
    pub(crate) fn bound(&self) -> Option<f64> {
        if self.heap.len() < self.count { None } else { self.heap.peek().map(|worst| worst.distance) }
    }

    #[inline]
    pub(crate) fn offer(&mut self, candidate: Neighbour) {
        if self.heap.len() < self.count {
            self.heap.push(candidate);
        } else if let Some(mut worst) = self.heap.peek_mut()
            && candidate < *worst
        {
            *worst = candidate;
        }
    }

    pub(crate) fn into_sorted(self) -> Vec<Neighbour> {
        self.heap.into_sorted_vec()
    }
}

impl Ord for Neighbour {
    fn cmp(&self, other: &Self) -> Ordering {
        self.distance.total_cmp(&other.distance).then(self.index.cmp(&other.index))
    }
}

impl PartialOrd for Neighbour {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Neighbour {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Neighbour {}
