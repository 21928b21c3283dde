//! The ranks of vectors, and those that are kept.

use super::{Fifo, Item};
use crate::hardware::{Burst, FILTER_WAITING, RANKS_IN_FLIGHT};
use crate::search::SearchParameters;
use raypath_model::state;
use std::collections::VecDeque;

/// A vector or a marker behind the beats.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sent {
    pub burst: Burst,
    pub context: u8,
    pub index: u32,
    pub failed: bool,
    pub key: u32,
    pub is_rank: bool,
}

#[derive(Debug, Clone)]
pub struct Ranks {
    sent: Fifo<Sent>,
    count: u32,
    /// Whether an outcome enters the divider, and so on, in the order of the cycles.
    line: VecDeque<bool>,
    keys: Fifo<()>,
}

state! {
    Sent { burst, context, index, failed, key, is_rank }
    Ranks { sent, count, line, keys }
    Filter { limits, taken, kept, count }
}

impl Ranks {
    pub fn new(divider_latency: u32) -> Self {
        // The operands, the quotient, the factors, the product and the key are in registers.
        let line = (0..divider_latency + 5).map(|_| false).collect();
        Self { sent: Fifo::new(), count: 0, line, keys: Fifo::new() }
    }

    pub fn can_send(&self) -> bool {
        self.count < RANKS_IN_FLIGHT
    }

    /// The first of the vectors and markers, if its key is there. Norms are none.
    pub fn first(&self) -> Option<Sent> {
        self.head().filter(|sent| sent.burst != Burst::Norm)
    }

    fn head(&self) -> Option<Sent> {
        self.sent.first().copied().filter(|sent| sent.burst.is_marker() || self.keys.first().is_some())
    }

    /// The clock edge. Returns the search and the key of its query's norm, if one leaves.
    pub fn edge(&mut self, sent: Option<Sent>, has_outcome: bool, is_taken: bool) -> Option<(u8, u32)> {
        let head = self.head();
        let norm = head.filter(|sent| sent.burst == Burst::Norm);
        let pops = is_taken || norm.is_some();
        let pops_key = pops && head.is_some_and(|sent| !sent.burst.is_marker());
        self.count = self.count + u32::from(sent.is_some()) - u32::from(pops);
        let has_key = self.line.pop_front().unwrap_or_default();
        self.line.push_back(has_outcome);
        self.keys.edge(has_key.then_some(()), pops_key);
        self.sent.edge(sent, pops);
        norm.map(|sent| (sent.context, sent.key))
    }
}

/// What drops the vectors that are too far away.
#[derive(Debug, Clone)]
pub struct Filter {
    limits: Vec<(u32, u32)>,
    /// What was taken in the last cycle, with the limit at that time.
    taken: Option<(Sent, (u32, u32))>,
    kept: Fifo<Item>,
    count: u32,
}

impl Filter {
    pub fn new(parameters: SearchParameters) -> Self {
        let limits = vec![(0, 0); parameters.contexts as usize];
        Self { limits, taken: None, kept: Fifo::new(), count: 0 }
    }

    pub fn can_take(&self) -> bool {
        self.count < FILTER_WAITING
    }

    pub fn next(&self) -> Option<Item> {
        self.kept.first().copied()
    }

    pub fn limit(&mut self, context: u8, limit: (u32, u32)) {
        self.limits[usize::from(context)] = limit;
    }

    pub fn edge(&mut self, next: Option<Sent>, pops: bool) {
        let kept = self.taken.and_then(|(sent, limit)| {
            let Sent { burst, context, index, failed, key, is_rank } = sent;
            let is_kept = burst.is_marker() || (is_rank && (key, index) <= limit);
            is_kept.then_some(Item { burst, context, index, key, failed })
        });
        let drops = self.taken.is_some() && kept.is_none();
        self.count = self.count + u32::from(next.is_some()) - u32::from(drops) - u32::from(pops);
        self.kept.edge(kept, pops);
        self.taken = next.map(|sent| (sent, self.limits[usize::from(sent.context)]));
    }
}
