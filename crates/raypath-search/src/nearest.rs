use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// The nearest candidates so far, of those that have been offered.
#[derive(Debug, Clone)]
pub(crate) struct Nearest {
    heap: BinaryHeap<Candidate>,
    count: usize,
}

/// A candidate and what it is ordered by; equal keys by index.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Candidate {
    /// Anything that grows with the distance; not a NaN.
    pub(crate) key: f64,
    /// Its index in the base.
    pub(crate) index: u32,
}

impl Nearest {
    /// For the `count` nearest, at least one.
    pub(crate) fn new(count: usize) -> Self {
        Self { heap: BinaryHeap::with_capacity(count), count }
    }

    /// The key of the farthest, which a candidate must not exceed; `None` as long as there is room for any.
    #[inline]
    pub(crate) fn bound(&self) -> Option<f64> {
        if self.heap.len() < self.count { None } else { self.heap.peek().map(|worst| worst.key) }
    }

    /// Takes a candidate in if it is nearer than the farthest.
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

    /// All of them, nearest first.
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
