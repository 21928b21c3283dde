//! Traffic at the ports of a unit: scenes, rays, a memory that answers in any order, and users that stall.

mod random_searches;
mod recorded;
mod scatter;
mod scene;
mod searches;
mod two_level;

pub use random_searches::random_searches;
pub use recorded::{RecordedCycle, RecordedEngine};
pub use scatter::invalid_child;
pub use scene::{BlockScene, never, random_ray};
pub use searches::{SearchBehaviour, SearchTraffic};
pub use two_level::TwoLevelScene;

use crate::{
    AskedCandidate, BlockRequest, Candidate, Memory, RayRequest, Reply, Response, SearchInputs, UnitEngine, UnitInputs,
    UnitOutputs, UnitParameters, Verdict,
};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::collections::BTreeMap;
use thiserror::Error;

/// How a memory and the users of the other channels behave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Behaviour {
    /// The least and greatest cycles from a request to the first beat.
    pub latency: (u64, u64),
    /// The share of cycles in which a stall of each channel begins, in 256ths: rays, hits, requests, responses.
    pub stalls: [u32; 4],
    /// The share of beats with an error, in 65,536ths.
    pub errors: u32,
}

/// What a unit must not do, in which cycle.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct ProtocolError(pub String);

/// A memory that answers in any order, and users of the other channels that stall at random. A block without an
/// address in the scene is an error of the memory.
///
/// The id of a ray is its number, cut to the unit's width of ids. A ray waits while another with its id is inside.
pub struct Environment<'s, M: ?Sized = [u8]> {
    memory: &'s M,
    parameters: UnitParameters,
    /// The bits of an address that the memory reads.
    address_mask: u64,
    behaviour: Behaviour,
    /// The cycles of the longest stall, and the cycle up to which each channel stalls.
    longest_stall: u64,
    stalled: [u64; 4],
    random: ChaCha8Rng,
    now: u64,
    pending: Vec<Pending>,
    rays: Vec<RayRequest>,
    next: usize,
    /// The rays inside, by their ids: the number of each, and the cycle in which it was accepted.
    inside: BTreeMap<u64, (u64, u64)>,
    /// The offer stays until it is accepted.
    offers: bool,
    /// The hit and the request that wait.
    held: (Option<(u64, Reply)>, Option<BlockRequest>),
    /// The candidate that waits, and verdicts with the cycle from which on they are given.
    held_candidate: Option<AskedCandidate>,
    verdicts: Vec<(u64, u32, Verdict)>,
    /// A flush begins in this cycle, or rays are dropped until the unit is idle.
    asks_flush: bool,
    flushes: bool,
    /// How many rays were inside at resets and flushes.
    lost: usize,
    latencies: BTreeMap<u64, u64>,
    failed: u64,
    moved: u64,
    /// Searches, which the unit does beside the rays.
    pub searches: Option<SearchTraffic<'s>>,
    /// The replies of the rays that have ended, by the numbers of the rays.
    pub replies: BTreeMap<u64, Reply>,
}

struct Pending {
    due: u64,
    tag: u32,
    block: Vec<u8>,
    is_missing: bool,
    is_failed: bool,
    beat: usize,
}

impl<'s> Environment<'s> {
    /// The environment of a unit with these parameters: a memory with a scene, and rays, whose numbers are their
    /// places.
    pub fn new(
        scene: &'s [u8],
        parameters: UnitParameters,
        rays: Vec<RayRequest>,
        behaviour: Behaviour,
        seed: u64,
    ) -> Self {
        Self::with_memory(scene, parameters, rays, behaviour, seed)
    }
}

impl<'s, M: Memory + ?Sized> Environment<'s, M> {
    /// The same with any memory.
    pub fn with_memory(
        memory: &'s M,
        parameters: UnitParameters,
        rays: Vec<RayRequest>,
        behaviour: Behaviour,
        seed: u64,
    ) -> Self {
        Self {
            memory,
            parameters,
            address_mask: u64::MAX,
            behaviour,
            longest_stall: 1,
            stalled: [0; 4],
            random: ChaCha8Rng::seed_from_u64(seed),
            now: 0,
            pending: Vec::new(),
            inside: BTreeMap::new(),
            rays,
            next: 0,
            offers: false,
            held: (None, None),
            held_candidate: None,
            verdicts: Vec::new(),
            replies: BTreeMap::new(),
            asks_flush: false,
            flushes: false,
            lost: 0,
            latencies: BTreeMap::new(),
            searches: None,
            failed: 0,
            moved: 0,
        }
    }

    /// Stalls take up to so many cycles, so that queues fill. Otherwise each takes one.
    pub fn with_longest_stall(self, cycles: u64) -> Self {
        Self { longest_stall: cycles.max(1), ..self }
    }

    /// The same with a memory that reads these bits of an address alone.
    pub fn ignoring_upper_bits(self, address_mask: u32) -> Self {
        Self { address_mask: address_mask.into(), ..self }
    }

    /// Whether all rays and searches have ended, or were lost in a reset or a flush.
    pub fn is_done(&self) -> bool {
        let searches = self.searches.as_ref();
        !self.flushes
            && self.replies.len() + self.lost == self.rays.len()
            && searches.is_none_or(SearchTraffic::is_done)
    }

    /// The cycles so far.
    pub fn cycles(&self) -> u64 {
        self.now
    }

    /// The cycles from the acceptance of each ray to its hit.
    pub fn latencies(&self) -> &BTreeMap<u64, u64> {
        &self.latencies
    }

    /// The blocks with an error in one of their beats that arrived, and were not forgotten in a reset.
    pub fn failed_blocks(&self) -> u64 {
        self.failed
    }

    /// The cycles since the last ray, hit, request or beat.
    pub fn idle(&self) -> u64 {
        self.now - self.moved
    }

    /// Asks for a flush in the next cycle: rays that are then inside are lost.
    pub fn flush(&mut self) {
        self.asks_flush = true;
    }

    /// Resets all engines. Rays inside are lost, and the memory forgets its requests if it is reset as well.
    pub fn reset(&mut self, engines: &mut [&mut dyn UnitEngine], with_memory: bool) {
        engines.iter_mut().for_each(|engine| engine.reset());
        if with_memory {
            self.pending.clear();
        }
        self.lost += self.inside.len();
        self.inside.clear();
        self.held = (None, None);
        (self.held_candidate, self.offers, self.asks_flush, self.flushes) = (None, false, false, false);
        self.verdicts.clear();
        if let Some(searches) = &mut self.searches {
            searches.reset();
        }
        self.now += 1;
    }

    /// Runs all engines in lockstep for a cycle.
    ///
    /// # Errors
    /// The engines differ; a hit is that of no ray inside; a request is not aligned or has a tag in use; a hit or a
    /// request that waits changes; a beat is not taken; the unit is idle with a ray inside or a response under way, or
    /// it is not idle without.
    pub fn cycle(&mut self, engines: &mut [&mut dyn UnitEngine]) -> Result<(), ProtocolError> {
        let now = self.now;
        let mut all = engines.iter_mut().map(|engine| engine.outputs());
        let Some(outputs) = all.next() else { return Ok(()) };
        for (number, other) in (1..).zip(all) {
            if other != outputs || ray_bits(&other) != ray_bits(&outputs) {
                return Err(wrong(format!("cycle {now}: engine {number} shows {other:?}, engine 0 {outputs:?}")));
            }
        }
        let (hit, request) = &self.held;
        if hit.is_some() && hit.map(same) != outputs.hit.map(same) || request.is_some() && *request != outputs.request {
            return Err(wrong(format!("cycle {now}: {:?} waits and becomes {outputs:?}", self.held)));
        }
        if self.held_candidate.is_some() && self.held_candidate != outputs.candidate {
            return Err(wrong(format!("cycle {now}: {:?} waits and becomes {outputs:?}", self.held_candidate)));
        }
        for (until, share) in self.stalled.iter_mut().zip(self.behaviour.stalls) {
            if *until <= now && self.random.random_range(0..256) < share {
                *until = now + self.random.random_range(1..=self.longest_stall);
            }
        }
        let owed = self.pending.len() + self.verdicts.len();
        if self.flushes && outputs.is_idle {
            self.lost += self.inside.len();
            self.inside.clear();
            self.flushes = false;
        }
        if (outputs.is_idle != self.inside.is_empty() || outputs.is_idle && owed > 0) && !self.flushes {
            let (idle, inside) = (outputs.is_idle, self.inside.len());
            return Err(wrong(format!(
                "cycle {now}: idle is {idle}, with {inside} rays inside and {owed} answers owed"
            )));
        }
        if !outputs.response_ready {
            return Err(wrong(format!("cycle {now}: a beat is not taken")));
        }
        let stalls = self.stalled.map(|until| now < until);
        let id = self.next as u64 & u64::MAX >> (64 - self.parameters.id_width);
        self.offers |= !stalls[0] && self.next < self.rays.len() && !self.inside.contains_key(&id);
        let ray = self.offers.then(|| (self.next as u64, self.rays[self.next]));
        let (hit_ready, request_ready) = (!stalls[1], !stalls[2]);
        let candidate_ready = outputs.candidate.is_some() && self.random.random();
        let due = self.verdicts.iter().position(|(due, ..)| *due <= now);
        let verdict = due.map(|place| self.verdicts.swap_remove(place)).map(|(_, tag, verdict)| (tag, verdict));
        let due: Vec<usize> = (0..self.pending.len()).filter(|&k| self.pending[k].due <= now).collect();
        let chosen = (!stalls[3] && !due.is_empty()).then(|| due[self.random.random_range(0..due.len())]);
        let is_error = self.random.random_range(0..65_536) < self.behaviour.errors;
        let (mut beat, beat_bytes) = (Vec::new(), self.parameters.memory_width as usize / 8);
        let response = chosen.map(|k| {
            let Pending { tag, block, is_missing, beat: number, .. } = &self.pending[k];
            beat.extend(&block[number * beat_bytes..][..beat_bytes]);
            Response { tag: *tag, is_error: is_error || *is_missing, beat: &beat }
        });
        let flush = std::mem::take(&mut self.asks_flush);
        if self.searches.as_ref().is_some_and(|searches| searches.moves) {
            self.moved = now;
        }
        let search = match (&mut self.searches, &outputs.search) {
            (Some(searches), Some(outputs)) => searches.cycle(outputs)?,
            _ => SearchInputs::default(),
        };
        let inputs = UnitInputs { flush, ray, hit_ready, candidate_ready, verdict, request_ready, response, search };
        engines.iter_mut().for_each(|engine| engine.cycle(&inputs));
        let mut counts = engines.iter().filter_map(|engine| engine.counts());
        if let Some(first) = counts.next()
            && let Some(other) = counts.find(|other| *other != first)
        {
            return Err(wrong(format!("cycle {now}: an engine counts {other:?}, another {first:?}")));
        }

        if let Some(k) = chosen {
            self.moved = now;
            self.pending[k].beat += 1;
            self.pending[k].is_failed |= is_error || self.pending[k].is_missing;
            if self.pending[k].beat * beat_bytes == self.pending[k].block.len() {
                self.failed += u64::from(self.pending.swap_remove(k).is_failed);
            }
        }
        if outputs.ray_ready && ray.is_some() {
            self.moved = now;
            self.inside.insert(id, (self.next as u64, now));
            self.next += 1;
            self.offers = false;
        }
        self.held_candidate = outputs.candidate.filter(|_| !candidate_ready);
        if let (Some(AskedCandidate { tag, candidate, .. }), true) = (outputs.candidate, candidate_ready) {
            let due = now + [1, 2, 30][self.random.random_range(0..3)];
            self.verdicts.push((due, tag, verdict_of(&candidate)));
            self.moved = now;
        }
        self.held = (outputs.hit.filter(|_| !hit_ready), outputs.request.filter(|_| !request_ready));
        self.take(outputs, hit_ready, request_ready)?;
        if flush {
            self.flushes = true;
            (self.held.0, self.held_candidate) = (None, None);
        }
        self.now += 1;
        Ok(())
    }

    /// Takes a hit and a request.
    fn take(&mut self, outputs: UnitOutputs, hit_ready: bool, request_ready: bool) -> Result<(), ProtocolError> {
        let now = self.now;
        if let (Some((id, reply)), true) = (outputs.hit, hit_ready) {
            let Some((number, entered)) = self.inside.remove(&id) else {
                return Err(wrong(format!("cycle {now}: a ray with the id {id} ends and is not inside")));
            };
            self.moved = now;
            self.latencies.insert(number, now - entered);
            self.replies.insert(number, reply);
        }
        if let (Some(BlockRequest { address, tag }), true) = (outputs.request, request_ready) {
            let bytes = self.parameters.step.node.block_bytes();
            if !address.is_multiple_of(bytes.into()) {
                return Err(wrong(format!("cycle {now}: the address {address:#x} is not aligned")));
            }
            if self.pending.iter().any(|pending| pending.tag == tag) {
                return Err(wrong(format!("cycle {now}: tag {tag} is in use")));
            }
            self.moved = now;
            let (least, greatest) = self.behaviour.latency;
            let found = self.memory.block(address & self.address_mask, bytes);
            self.pending.push(Pending {
                due: now + self.random.random_range(least..=greatest),
                tag,
                block: found.map_or_else(|_| vec![0xff; bytes as usize], <[u8]>::to_vec),
                is_missing: found.is_err(),
                is_failed: false,
                beat: 0,
            });
        }
        Ok(())
    }
}

/// A verdict that depends on the indices of the candidate alone: each of those that there are.
pub fn verdict_of(candidate: &Candidate) -> Verdict {
    let Candidate { hit, is_box, .. } = candidate;
    let instance = hit.instance.map_or(7, |instance| instance.index);
    let mixed = [hit.primitive, hit.geometry, instance]
        .into_iter()
        .fold(0_u32, |mixed, index| (mixed ^ index).wrapping_mul(0x9e37_79b9).rotate_left(13));
    // A box is often at a distance that does not count.
    let t = if *is_box { [0.5, 1.5, 3.0, f32::NAN, 100.0, -1.0][mixed as usize / 64 % 6] } else { 0.0 };
    Verdict { accepts: mixed % 8 < 3, ends: mixed / 8 % 16 == 0, t }
}

/// The ray of a candidate in bits, by which zeros of both signs differ.
fn ray_bits(outputs: &UnitOutputs) -> Option<[[u32; 3]; 2]> {
    let bits = |vector: [f32; 3]| vector.map(f32::to_bits);
    outputs.candidate.map(|AskedCandidate { candidate, .. }| [candidate.origin, candidate.direction].map(bits))
}

/// A hit in words, which are equal for equal NaN.
fn same((id, reply): (u64, Reply)) -> String {
    format!("{id} {reply:?}")
}

fn wrong(problem: String) -> ProtocolError {
    ProtocolError(problem)
}
