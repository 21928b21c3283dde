//! Merges gates of a network, and orders them so that many of one kind follow each other.

use super::network::{Bit, Gate, Kind, Network, Two};
use std::collections::VecDeque;

/// The number of gates that are ordered together. With more, runs of one kind are longer, and more values are live.
const WINDOW: usize = 8192;

/// The needed gates of a network, in order.
pub struct Schedule {
    /// By position in the network.
    pub gates: Vec<Gate>,
    /// The gates that `kept` depends on, operands before readers.
    pub order: Vec<usize>,
}

impl Schedule {
    pub fn new(network: &Network, kept: &[Bit]) -> Self {
        let mut gates = network.gates.clone();
        pair(&mut gates, &readers(network, &network.gates, kept));
        let needed = readers(network, &gates, kept);
        let needed: Vec<usize> = (0..gates.len()).filter(|&gate| needed[gate] > 0).collect();
        let mut order = Vec::with_capacity(needed.len());
        let mut places = vec![usize::MAX; gates.len()];
        let is_operation = |gate: &usize| matches!(gates[*gate], Gate::Operation(..));
        for part in needed.chunk_by(|a, b| is_operation(a) == is_operation(b)) {
            if is_operation(&part[0]) {
                part.chunks(WINDOW).for_each(|window| by_kind(&gates, window, &mut places, &mut order));
            } else {
                // A call's results are copied at once: their order stays as it is.
                order.extend(part);
            }
        }
        Self { gates, order }
    }
}

/// The number of readers of each gate, among the gates that `kept` depends on. A kept bit has one reader more.
fn readers(network: &Network, gates: &[Gate], kept: &[Bit]) -> Vec<u32> {
    let mut readers = vec![0; gates.len()];
    for bit in kept {
        readers[bit.index()] += 1;
    }
    for (place, gate) in gates.iter().enumerate().rev() {
        if readers[place] > 0 {
            for operand in network.operands(gate) {
                readers[operand.index()] += 1;
            }
        }
    }
    readers
}

/// Merges an operand into the gate that reads it, if it has no other reader.
fn pair(gates: &mut [Gate], readers: &[u32]) {
    for gate in 0..gates.len() {
        let Gate::Operation(Kind::Two(second), [a, b, _]) = gates[gate] else { continue };
        let swapped = match second {
            Two::AndNot => Two::NotAnd,
            Two::NotAnd => Two::AndNot,
            Two::And | Two::Or | Two::Xor => second,
        };
        for (inside, second, other) in [(a, second, b), (b, swapped, a)] {
            if readers[inside.index()] == 1
                && let Gate::Operation(Kind::Two(first), [x, y, _]) = gates[inside.index()]
            {
                gates[gate] = Gate::Operation(Kind::Pair(first, second), [x, y, other]);
                break;
            }
        }
    }
}

/// Adds a window's gates to the order: always all ready gates of the kind that has most of them. `places` holds the
/// position of each gate in its window.
fn by_kind(gates: &[Gate], window: &[usize], places: &mut [usize], order: &mut Vec<usize>) {
    for (place, &gate) in window.iter().enumerate() {
        places[gate] = place;
    }
    let mut readers: Vec<Vec<usize>> = vec![Vec::new(); window.len()];
    let mut waits = vec![0; window.len()];
    let mut ready = Ready::default();
    for (place, &gate) in window.iter().enumerate() {
        let Gate::Operation(kind, operands) = gates[gate] else { continue };
        for operand in &operands[..kind.operands()] {
            // Places from earlier windows are those of other gates.
            let operand_place = places[operand.index()];
            if window.get(operand_place) == Some(&operand.index()) {
                readers[operand_place].push(place);
                waits[place] += 1;
            }
        }
        if waits[place] == 0 {
            ready.push(kind, place);
        }
    }
    while let Some(kind) = ready.longest() {
        while let Some(place) = ready.queues[kind].1.pop_front() {
            order.push(window[place]);
            for &reader in &readers[place] {
                waits[reader] -= 1;
                if waits[reader] == 0
                    && let Gate::Operation(kind, _) = gates[window[reader]]
                {
                    ready.push(kind, reader);
                }
            }
        }
    }
}

/// Gates whose operands are computed, by kind.
#[derive(Default)]
struct Ready {
    queues: Vec<(Kind, VecDeque<usize>)>,
}

impl Ready {
    fn push(&mut self, kind: Kind, place: usize) {
        match self.queues.iter_mut().find(|(of, _)| *of == kind) {
            Some((_, queue)) => queue.push_back(place),
            None => self.queues.push((kind, VecDeque::from([place]))),
        }
    }

    fn longest(&self) -> Option<usize> {
        let lengths = self.queues.iter().map(|(_, queue)| queue.len()).enumerate();
        lengths.max_by_key(|&(_, length)| length).filter(|&(_, length)| length > 0).map(|(kind, _)| kind)
    }
}
