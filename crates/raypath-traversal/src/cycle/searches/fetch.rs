//! The blocks of searches, in the order in which they were asked for.

use super::Fifo;
use crate::engine::{BlockRequest, Response};
use crate::hardware::Burst;
use crate::search::{SEARCH_BLOCK, SearchParameters};
use raypath_model::{State, StateWords, state};

/// Blocks that follow each other, or a marker.
#[derive(Debug, Clone, Copy, Default)]
pub struct Blocks {
    pub burst: Burst,
    pub context: u8,
    pub index: u32,
    pub address: u64,
    pub count: u32,
}

/// A block of a burst.
#[derive(Debug, Clone, Copy, Default)]
pub struct Entry {
    pub burst: Burst,
    pub context: u8,
    pub index: u32,
    pub is_last: bool,
}

/// The bytes of a block.
pub type Block = [u8; SEARCH_BLOCK as usize];

#[derive(Debug, Clone)]
pub struct Fetch {
    burst: Option<Blocks>,
    entries: Fifo<Entry>,
    head: u32,
    tail: u32,
    slots: Vec<Slot>,
    request: Option<BlockRequest>,
    beat_bytes: usize,
}

#[derive(Debug, Clone, Copy)]
struct Slot {
    has_arrived: bool,
    has_failed: bool,
    beats: usize,
    block: Block,
}

state! {
    Blocks { burst, context, index, address, count }
    Entry { burst, context, index, is_last }
    Fetch { burst, entries, head, tail, slots, request }
    Slot { has_arrived, has_failed, beats, block }
}

impl State for BlockRequest {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        self.address.pass(words);
        self.tag.pass(words);
    }
}

impl Fetch {
    pub fn new(parameters: SearchParameters, memory_width: u32) -> Self {
        let slot = Slot { has_arrived: false, has_failed: false, beats: 0, block: [0; SEARCH_BLOCK as usize] };
        Self {
            burst: None,
            entries: Fifo::new(),
            head: 0,
            tail: 0,
            slots: vec![slot; parameters.blocks as usize],
            request: None,
            beat_bytes: memory_width as usize / 8,
        }
    }

    pub fn request(&self) -> Option<BlockRequest> {
        self.request
    }

    /// Whether the first block of the queue has arrived.
    pub fn has_head(&self) -> bool {
        self.entries.first().is_some() && self.slots[self.place(self.head)].has_arrived
    }

    /// Whether the burst's next block, or the marker, enters the queue, if the request that waits is taken or not.
    fn pushes(&self, request_ready: bool) -> bool {
        let is_full = self.tail.wrapping_sub(self.head) as usize == self.slots.len();
        let can_request = |burst: Blocks| burst.burst.is_marker() || self.request.is_none() || request_ready;
        self.burst.is_some_and(|burst| !is_full && can_request(burst))
    }

    /// Whether a burst is taken.
    pub fn is_ready(&self, request_ready: bool) -> bool {
        self.burst.is_none_or(|burst| self.pushes(request_ready) && (burst.burst.is_marker() || burst.count == 1))
    }

    /// The clock edge. Returns the first block of the queue, with its bytes and whether it has failed, if it is taken.
    pub fn edge(
        &mut self,
        burst: Option<Blocks>,
        request_ready: bool,
        response: Option<&Response<'_>>,
        take: bool,
    ) -> Option<(Entry, Block, bool)> {
        let pushes = self.pushes(request_ready);
        let is_ready = self.is_ready(request_ready);
        let taken = take.then(|| self.take()).flatten();
        if request_ready {
            self.request = None;
        }
        let mut entry = None;
        if let (Some(blocks), true) = (&mut self.burst, pushes) {
            let Blocks { burst, context, index, address, count } = *blocks;
            let is_marker = burst.is_marker();
            entry = Some(Entry { burst, context, index, is_last: is_marker || count == 1 });
            let place = self.tail as usize % self.slots.len();
            if is_marker {
                self.slots[place].has_arrived = true;
            } else {
                self.request = Some(BlockRequest { address, tag: place as u32 });
            }
            // Blocks follow each other in the 4 GiB of the job.
            let next = (address as u32).wrapping_add(SEARCH_BLOCK);
            (blocks.address, blocks.count) = (address & !u64::from(u32::MAX) | u64::from(next), count.wrapping_sub(1));
            self.tail = self.tail.wrapping_add(1);
        }
        self.entries.edge(entry, taken.is_some());
        if is_ready {
            self.burst = burst;
        }
        if let Some(response) = response {
            self.arrive(response);
        }
        taken
    }

    fn take(&mut self) -> Option<(Entry, Block, bool)> {
        let place = self.place(self.head);
        let entry = *self.entries.first()?;
        let slot = &mut self.slots[place];
        slot.has_arrived = false;
        self.head = self.head.wrapping_add(1);
        Some((entry, slot.block, slot.has_failed))
    }

    fn arrive(&mut self, response: &Response<'_>) {
        let Some(slot) = self.slots.get_mut(response.tag as usize) else { return };
        let Some(place) = slot.block.get_mut(slot.beats * self.beat_bytes..) else { return };
        place.iter_mut().zip(response.beat).for_each(|(to, from)| *to = *from);
        slot.has_failed = response.is_error || (slot.has_failed && slot.beats > 0);
        slot.beats += 1;
        if slot.beats * self.beat_bytes == SEARCH_BLOCK as usize {
            (slot.beats, slot.has_arrived) = (0, true);
        }
    }

    fn place(&self, number: u32) -> usize {
        number as usize % self.slots.len()
    }
}
