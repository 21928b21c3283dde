use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// The nearest of the candidates offered so far.
#[derive(Debug, Clone)]
pub(crate) struct Nearest {
    heap: BinaryHeap<Candidate>,
    count: usize,
}

/// A candidate, ordered by key and then by index.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Candidate {
    /// A monotonic function of the distance; not NaN.
    pub(crate) key: f64,
    /// The index in the base.
    pub(crate) index: u32,
}

impl Nearest {
    /// A collection of the `count` nearest candidates; `count` is at least 1.
    pub(crate) fn new(count: usize) -> Self {
        Self { heap: BinaryHeap::with_capacity(count), count }
    }

    /// The key of the farthest candidate; `None` while there are fewer than `count`.
    #[inline]
    pub(crate) fn bound(&self) -> Option<f64> {
        if self.heap.len() < self.count { None } else { self.heap.peek().map(|worst| worst.key) }
    }

    /// Adds a candidate if it is among the nearest.
    #[inline]
    pub(crate) fn offer(&mut self, candidate: Candidate) {
        if self.heap.len() < self.count {
            self.heap.push(candidate);
        } else if let Some(mut worst) = self.heap.peek_mut()
            && candidate < *worst
        {
            *worst = candidate;
        }
    }

    /// The candidates, nearest first.
    pub(crate) fn into_sorted(self) -> Vec<Candidate> {
        self.heap.into_sorted_vec()
    }
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        self.key.total_cmp(&other.key).then(self.index.cmp(&other.index))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Candidate {}
