//! The cut with the fewest bits.

use std::collections::VecDeque;

/// A minimum cut between what is before and what is after, with the bits of a signal that is read behind the cut as its
/// costs.
pub struct Network {
    /// For each vertex its edges: target, capacity, and the position of the reverse edge. Signal `i` has the vertices
    /// `2 i`, before the bits that it carries, and `2 i + 1` behind them.
    edges: Vec<Vec<(usize, u64, usize)>>,
}

/// More than any number of bits.
const UNLIMITED: u64 = 1 << 40;

impl Network {
    pub fn new(signals: usize) -> Self {
        Self { edges: vec![Vec::new(); 2 * signals + 2] }
    }

    fn source(&self) -> usize {
        self.edges.len() - 2
    }

    fn edge(&mut self, from: usize, to: usize, capacity: u64) {
        let (forward, backward) = (self.edges[from].len(), self.edges[to].len());
        self.edges[from].push((to, capacity, backward));
        self.edges[to].push((from, 0, forward));
    }

    pub fn carries(&mut self, signal: usize, bits: u32) {
        self.edge(2 * signal, 2 * signal + 1, bits.into());
    }

    /// A reader behind the cut needs the bits; a signal behind the cut has no reader before it.
    pub fn reads(&mut self, reader: usize, signal: usize) {
        self.edge(2 * signal + 1, 2 * reader, UNLIMITED);
        self.edge(2 * reader, 2 * signal, UNLIMITED);
    }

    /// Both signals are on the same side.
    pub fn joins(&mut self, signal: usize, other: usize) {
        self.edge(2 * signal, 2 * other, UNLIMITED);
        self.edge(2 * other, 2 * signal, UNLIMITED);
    }

    pub fn fix_before(&mut self, signal: usize) {
        self.edge(self.source(), 2 * signal, UNLIMITED);
    }

    pub fn fix_after(&mut self, signal: usize) {
        self.edge(2 * signal, self.source() + 1, UNLIMITED);
    }

    pub fn read_after(&mut self, signal: usize) {
        self.edge(2 * signal + 1, self.source() + 1, UNLIMITED);
    }

    /// Whether each signal is behind the minimum cut that is nearest to the source (Edmonds and Karp).
    pub fn minimum_cut(mut self) -> Vec<bool> {
        let (source, sink) = (self.source(), self.source() + 1);
        loop {
            let mut reached: Vec<Option<(usize, usize)>> = vec![None; self.edges.len()];
            let mut open = VecDeque::from([source]);
            while let Some(vertex) = open.pop_front() {
                for (place, &(to, capacity, _)) in self.edges[vertex].iter().enumerate() {
                    if capacity > 0 && to != source && reached[to].is_none() {
                        reached[to] = Some((vertex, place));
                        open.push_back(to);
                    }
                }
            }
            if reached[sink].is_none() {
                return (0..source / 2).map(|signal| reached[2 * signal].is_none()).collect();
            }
            let path: Vec<(usize, usize)> = std::iter::successors(reached[sink], |&(from, _)| reached[from]).collect();
            let flow = path.iter().map(|&(from, place)| self.edges[from][place].1).min().unwrap_or(0);
            for (from, place) in path {
                let (to, _, back) = self.edges[from][place];
                self.edges[from][place].1 -= flow;
                self.edges[to][back].1 += flow;
            }
        }
    }
}
