//! The graph of Malkov and Yashunin, *Efficient and robust approximate nearest neighbor search using Hierarchical
//! Navigable Small World graphs* (2018): its algorithms 1 (insert), 2 (search a layer) and 4 (select neighbours by the
//! heuristic, without the extensions).

use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The most layers above the lowest.
const MOST_UPPER: usize = 15;

/// A layered graph of items, which have numbers from 0.
#[derive(Debug)]
pub struct Hnsw {
    /// M: the connections of a new item in a layer, and the most in an upper layer; twice as many in the lowest.
    connections: usize,
    /// The neighbours in the lowest layer, `2 * connections` places for each item, and how many are used.
    lowest: Vec<u32>,
    used: Vec<u16>,
    /// The neighbours of each item in the layers above.
    upper: Vec<Vec<Vec<u32>>>,
    /// An item in the highest layer.
    entry: Option<u32>,
    scratch: Scratch,
}

/// An item and its distance, at least +0, in a word whose order is that of distances, then of numbers: the bits of
/// numbers that are not negative have their order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Near(u64);

impl Near {
    #[inline(always)]
    fn new(distance: f32, item: u32) -> Self {
        Self(u64::from(distance.to_bits()) << 32 | u64::from(item))
    }

    /// The number of the item.
    #[inline(always)]
    fn item(self) -> u32 {
        self.0 as u32
    }

    #[inline(always)]
    fn distance(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }
}

/// The items that a search has visited.
#[derive(Debug, Clone)]
struct Scratch {
    /// The number of the search that visited each item last.
    visited: Vec<u32>,
    search: u32,
}

impl Hnsw {
    /// A graph without items, for `count` of them.
    pub fn new(count: usize, connections: usize) -> Self {
        Self {
            connections,
            lowest: vec![0; 2 * connections * count],
            used: vec![0; count],
            upper: vec![Vec::new(); count],
            entry: None,
            scratch: Scratch::new(count),
        }
    }

    /// The places of an item for neighbours in the lowest layer, the neighbours of every item, and the item to begin
    /// with.
    pub fn lowest_layer(&self) -> (usize, Vec<Vec<u32>>, u32) {
        let degree = 2 * self.connections;
        let used = self.lowest.chunks(degree).zip(&self.used).map(|(places, used)| places[..usize::from(*used)].into());
        (degree, used.collect(), self.entry.unwrap_or(0))
    }

    /// Inserts an item. `ef` candidates are kept for each layer.
    // Inlined, as are its parts, so that distances are compiled for the instruction set of the caller.
    #[inline(always)]
    pub fn insert(&mut self, item: u32, ef: usize, random: &mut ChaCha8Rng, distance: &impl Fn(u32, u32) -> f32) {
        // 1 - u is above 0.
        let draw = -(1.0 - random.random::<f64>()).ln() / (self.connections as f64).ln();
        let level = (draw as usize).min(MOST_UPPER);
        self.upper[item as usize] = vec![Vec::new(); level];
        let Some(entry) = self.entry else {
            self.entry = Some(item);
            return;
        };
        let top = self.upper[entry as usize].len();
        let mut to_item = |other: u32| distance(item, other);
        let mut near = vec![Near::new(to_item(entry), entry)];
        let mut scratch = std::mem::take(&mut self.scratch);
        for layer in (level + 1..=top).rev() {
            near = self.search_layer(layer, near, 1, &mut scratch, &mut to_item);
        }
        for layer in (0..=level.min(top)).rev() {
            near = self.search_layer(layer, near, ef, &mut scratch, &mut to_item);
            let chosen = select(&near, self.connections, distance);
            for other in &chosen {
                self.connect(layer, other.item(), Near::new(other.distance(), item), distance);
            }
            self.set_neighbours(layer, item, &chosen);
        }
        self.scratch = scratch;
        if level > top {
            self.entry = Some(item);
        }
    }

    /// Algorithm 2: the nearest items of a layer, found from those of `near`, nearest first.
    #[inline(always)]
    fn search_layer(
        &self,
        layer: usize,
        near: Vec<Near>,
        ef: usize,
        scratch: &mut Scratch,
        distance: &mut impl FnMut(u32) -> f32,
    ) -> Vec<Near> {
        scratch.begin();
        for it in &near {
            scratch.visit(it.item());
        }
        let mut open: BinaryHeap<Reverse<Near>> = near.iter().copied().map(Reverse).collect();
        let mut found: BinaryHeap<Near> = near.into();
        while let Some(Reverse(next)) = open.pop() {
            if found.len() >= ef && found.peek().is_some_and(|farthest| next > *farthest) {
                break;
            }
            for &item in self.neighbours(layer, next.item()) {
                if !scratch.visit(item) {
                    continue;
                }
                let other = Near::new(distance(item), item);
                if found.len() < ef || found.peek().is_some_and(|farthest| other < *farthest) {
                    open.push(Reverse(other));
                    found.push(other);
                    if found.len() > ef {
                        found.pop();
                    }
                }
            }
        }
        found.into_sorted_vec()
    }

    #[inline(always)]
    fn neighbours(&self, layer: usize, item: u32) -> &[u32] {
        let item = item as usize;
        match layer.checked_sub(1) {
            None => &self.lowest[2 * self.connections * item..][..usize::from(self.used[item])],
            Some(upper) => &self.upper[item][upper],
        }
    }

    fn set_neighbours(&mut self, layer: usize, item: u32, near: &[Near]) {
        let item = item as usize;
        match layer.checked_sub(1) {
            None => {
                let places = &mut self.lowest[2 * self.connections * item..][..near.len()];
                places.iter_mut().zip(near).for_each(|(place, it)| *place = it.item());
                self.used[item] = near.len() as u16;
            }
            Some(upper) => self.upper[item][upper] = near.iter().map(|it| it.item()).collect(),
        }
    }

    /// Adds a neighbour to an item. If it has too many, the heuristic chooses among them.
    #[inline(always)]
    fn connect(&mut self, layer: usize, item: u32, added: Near, distance: &impl Fn(u32, u32) -> f32) {
        let most = if layer == 0 { 2 * self.connections } else { self.connections };
        let old = self.neighbours(layer, item);
        if old.len() < most {
            let count = old.len();
            match layer.checked_sub(1) {
                None => {
                    self.lowest[2 * self.connections * item as usize + count] = added.item();
                    self.used[item as usize] += 1;
                }
                Some(upper) => self.upper[item as usize][upper].push(added.item()),
            }
            return;
        }
        let mut near: Vec<Near> = old.iter().map(|&other| Near::new(distance(item, other), other)).collect();
        near.push(added);
        near.sort_unstable();
        let chosen = select(&near, most, distance);
        self.set_neighbours(layer, item, &chosen);
    }
}

/// Algorithm 4: of candidates, nearest first, at most `most` that are nearer to the item than to any chosen before.
#[inline(always)]
fn select(near: &[Near], most: usize, distance: &impl Fn(u32, u32) -> f32) -> Vec<Near> {
    let mut chosen: Vec<Near> = Vec::with_capacity(most);
    for candidate in near {
        if chosen.len() == most {
            break;
        }
        if chosen.iter().all(|it| distance(it.item(), candidate.item()) > candidate.distance()) {
            chosen.push(*candidate);
        }
    }
    chosen
}

impl Scratch {
    /// For a graph of `count` items.
    pub fn new(count: usize) -> Self {
        Self { visited: vec![0; count], search: 0 }
    }

    fn begin(&mut self) {
        self.search = self.search.wrapping_add(1);
        if self.search == 0 {
            self.visited.fill(0);
            self.search = 1;
        }
    }

    /// Whether an item is visited for the first time.
    fn visit(&mut self, item: u32) -> bool {
        std::mem::replace(&mut self.visited[item as usize], self.search) != self.search
    }
}

impl Default for Scratch {
    fn default() -> Self {
        Self::new(0)
    }
}
