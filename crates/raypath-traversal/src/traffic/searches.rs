//! Searches at the ports of a unit, and a memory that answers their requests in any order.

use super::{ProtocolError, wrong};
use crate::search::{Neighbour, SEARCH_BLOCK, SearchStatus};
use crate::{BlockRequest, Memory, Response, SearchInputs, SearchOutputs, SearchResult};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::collections::BTreeMap;

/// How the memory of searches and the user of results behave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SearchBehaviour {
    /// The least and greatest cycles from a request to the first beat.
    pub latency: (u64, u64),
    /// The share of cycles in which a channel is not ready, and in which no beat comes, in 256ths.
    pub stalls: u32,
    /// The share of beats with an error, in 65,536ths.
    pub errors: u32,
    /// Bits of a beat.
    pub memory_width: u32,
}

/// Jobs, whose numbers are their places, and a memory. A block that the memory does not have is an error.
pub struct SearchTraffic<'m> {
    memory: &'m dyn Memory,
    jobs: Vec<u32>,
    behaviour: SearchBehaviour,
    random: ChaCha8Rng,
    now: u64,
    next: usize,
    offers: bool,
    pending: Vec<Pending>,
    /// The result and the request that wait.
    held: (Option<SearchResult>, Option<BlockRequest>),
    beat: Vec<u8>,
    /// How each job has ended, and its neighbours, by its number.
    pub replies: BTreeMap<u64, (SearchStatus, Vec<Neighbour>)>,
    open: BTreeMap<u64, Vec<Neighbour>>,
    /// How many jobs were inside at resets.
    lost: usize,
    /// A channel moved in the last cycle.
    pub(super) moves: bool,
}

struct Pending {
    due: u64,
    tag: u32,
    address: u64,
    beat: usize,
}

impl<'m> SearchTraffic<'m> {
    /// Jobs at these addresses of the memory.
    pub fn new(memory: &'m dyn Memory, jobs: Vec<u32>, behaviour: SearchBehaviour, seed: u64) -> Self {
        Self {
            memory,
            jobs,
            behaviour,
            random: ChaCha8Rng::seed_from_u64(seed),
            now: 0,
            next: 0,
            offers: false,
            pending: Vec::new(),
            held: (None, None),
            beat: Vec::new(),
            replies: BTreeMap::new(),
            open: BTreeMap::new(),
            lost: 0,
            moves: false,
        }
    }

    /// All jobs have ended or were lost.
    pub(super) fn is_done(&self) -> bool {
        self.replies.len() + self.lost == self.jobs.len()
    }

    /// No job is in the unit.
    fn is_idle(&self) -> bool {
        self.replies.len() + self.lost == self.next
    }

    /// Jobs inside are lost, and the memory forgets its requests.
    pub(super) fn reset(&mut self) {
        self.lost = self.next - self.replies.len();
        self.pending.clear();
        self.open.clear();
        (self.held, self.offers) = ((None, None), false);
    }

    /// The inputs in a cycle with these outputs.
    pub(super) fn cycle(&mut self, outputs: &SearchOutputs) -> Result<SearchInputs<'_>, ProtocolError> {
        let now = self.now;
        self.now += 1;
        let SearchOutputs { is_idle, ready, result, request } = *outputs;
        if is_idle != self.is_idle() {
            let inside = self.next - self.replies.len() - self.lost;
            return Err(wrong(format!("cycle {now}: searches are idle is {is_idle}, with {inside} jobs inside")));
        }
        let (held, asked) = &self.held;
        if held.is_some() && *held != result || asked.is_some() && *asked != request {
            return Err(wrong(format!("cycle {now}: {:?} waits and becomes {outputs:?}", self.held)));
        }
        let stalls = self.behaviour.stalls;
        let [offers, result_ready, request_ready, answers] =
            [(); 4].map(|()| self.random.random_range(0..256) >= stalls);
        self.offers |= offers && self.next < self.jobs.len();
        let job = self.offers.then(|| (self.next as u64, 0, self.jobs[self.next]));
        if job.is_some() && ready {
            self.next += 1;
            self.offers = false;
        }
        self.held = (result.filter(|_| !result_ready), request.filter(|_| !request_ready));
        if let Some(result) = result.filter(|_| result_ready) {
            self.take(now, result)?;
        }
        let due: Vec<usize> = (0..self.pending.len()).filter(|&k| self.pending[k].due <= now).collect();
        let chosen = (answers && !due.is_empty()).then(|| due[self.random.random_range(0..due.len())]);
        let response = chosen.map(|k| self.answer(k));
        if let Some(request) = request.filter(|_| request_ready) {
            self.ask(now, request)?;
        }
        self.moves = job.is_some() && ready || result.is_some() && result_ready || response.is_some();
        let response = response.map(|(tag, is_error)| Response { tag, is_error, beat: &self.beat });
        Ok(SearchInputs { job, result_ready, request_ready, response })
    }

    fn take(&mut self, now: u64, result: SearchResult) -> Result<(), ProtocolError> {
        let SearchResult { id, rank, neighbour, status, is_last } = result;
        let before = self.open.entry(id).or_default();
        if id >= self.next as u64 || self.replies.contains_key(&id) || rank as usize != before.len() {
            return Err(wrong(format!("cycle {now}: the result {result:?} is not that of a job that is inside")));
        }
        before.extend(neighbour);
        if is_last {
            let neighbours = self.open.remove(&id).unwrap_or_default();
            self.replies.insert(id, (status, neighbours));
        }
        Ok(())
    }

    /// The next beat of a block: its tag, and whether it is an error.
    fn answer(&mut self, place: usize) -> (u32, bool) {
        let bytes = self.behaviour.memory_width.min(8 * SEARCH_BLOCK) as usize / 8;
        let Pending { tag, address, beat, .. } = &mut self.pending[place];
        let (tag, found) = (*tag, self.memory.block(*address, SEARCH_BLOCK));
        self.beat.clear();
        self.beat.extend(
            found.as_ref().map_or(&[0xff; SEARCH_BLOCK as usize][..bytes], |block| &block[*beat * bytes..][..bytes]),
        );
        let is_error = found.is_err() || self.random.random_range(0..65_536) < self.behaviour.errors;
        *beat += 1;
        if *beat * bytes == SEARCH_BLOCK as usize {
            self.pending.swap_remove(place);
        }
        (tag, is_error)
    }

    fn ask(&mut self, now: u64, BlockRequest { address, tag }: BlockRequest) -> Result<(), ProtocolError> {
        if !address.is_multiple_of(SEARCH_BLOCK.into()) || self.pending.iter().any(|pending| pending.tag == tag) {
            return Err(wrong(format!(
                "cycle {now}: the request of {address:#x} with tag {tag} is not aligned or in use"
            )));
        }
        let (least, greatest) = self.behaviour.latency;
        let due = now + self.random.random_range(least..=greatest);
        self.pending.push(Pending { due, tag, address, beat: 0 });
        Ok(())
    }
}
