//! Traffic at the ports of a unit: scenes, rays, a memory that answers in any order, and users that stall.

mod scene;

pub use scene::{BlockScene, never, random_ray};

use crate::blocks::BLOCK_BYTES;
use crate::{BlockRequest, Memory, RayRequest, Reply, Response, UnitEngine, UnitInputs};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::collections::BTreeMap;
use thiserror::Error;

/// How a memory and the users of the other channels behave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Behaviour {
    /// The least and greatest cycles from a request to the first beat.
    pub latency: (u64, u64),
    /// The share of cycles in which each channel stalls, in 256ths: rays, hits, requests, responses.
    pub stalls: [u32; 4],
    /// The share of beats with an error, in 65,536ths.
    pub errors: u32,
}

/// What a unit must not do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum ProtocolError {
    /// Two engines have different outputs.
    #[error("engines 0 and {engine} have different outputs in cycle {cycle}")]
    Different {
        /// The engine that differs from engine 0.
        engine: usize,
        /// The cycle.
        cycle: u64,
    },
    /// A ray ends that has ended or was never offered.
    #[error("ray {id} ends in cycle {cycle}, expected the end of a ray in flight")]
    End {
        /// The number of the ray.
        id: u64,
        /// The cycle.
        cycle: u64,
    },
    /// A request has a tag that is in use.
    #[error("a request has tag {tag} in cycle {cycle}, expected one that is not in use")]
    Tag {
        /// The tag.
        tag: u32,
        /// The cycle.
        cycle: u64,
    },
}

/// A memory that answers in any order, and users of the other channels that stall at random. A block without an
/// address in the scene is an error of the memory.
pub struct Environment<'s> {
    scene: &'s [u8],
    beat_bytes: usize,
    behaviour: Behaviour,
    random: ChaCha8Rng,
    now: u64,
    pending: Vec<Pending>,
    rays: Vec<RayRequest>,
    next: usize,
    /// The offer stays until it is accepted.
    offers: bool,
    /// The replies so far, by the number of the ray.
    pub replies: BTreeMap<u64, Reply>,
}

struct Pending {
    due: u64,
    tag: u32,
    block: [u8; BLOCK_BYTES as usize],
    is_missing: bool,
    beat: usize,
}

impl<'s> Environment<'s> {
    /// An environment of a unit with this width of the memory, in bits. The rays are numbered from 0 on.
    pub fn new(scene: &'s [u8], memory_width: u32, rays: Vec<RayRequest>, behaviour: Behaviour, seed: u64) -> Self {
        Self {
            scene,
            beat_bytes: memory_width as usize / 8,
            behaviour,
            random: ChaCha8Rng::seed_from_u64(seed),
            now: 0,
            pending: Vec::new(),
            rays,
            next: 0,
            offers: false,
            replies: BTreeMap::new(),
        }
    }

    /// Whether all rays have ended.
    pub fn is_done(&self) -> bool {
        self.replies.len() == self.rays.len()
    }

    /// The cycles so far.
    pub fn cycles(&self) -> u64 {
        self.now
    }

    /// Runs all engines in lockstep for a cycle. Without an engine, nothing happens.
    ///
    /// # Errors
    /// Engines differ, or break the protocol.
    pub fn cycle(&mut self, engines: &mut [&mut dyn UnitEngine]) -> Result<(), ProtocolError> {
        let cycle = self.now;
        let mut all = engines.iter_mut().map(|engine| engine.outputs());
        let Some(outputs) = all.next() else { return Ok(()) };
        if let Some(place) = all.position(|other| other != outputs) {
            return Err(ProtocolError::Different { engine: place + 1, cycle });
        }
        let stalls = self.behaviour.stalls.map(|share| self.random.random_range(0..256) < share);
        self.offers |= !stalls[0] && self.next < self.rays.len();
        let ray = self.offers.then(|| (self.next as u64, self.rays[self.next]));
        let (hit_ready, request_ready) = (!stalls[1], !stalls[2]);
        let due: Vec<usize> = (0..self.pending.len()).filter(|&k| self.pending[k].due <= self.now).collect();
        let chosen = (!stalls[3] && !due.is_empty()).then(|| due[self.random.random_range(0..due.len())]);
        let is_error = self.random.random_range(0..65_536) < self.behaviour.errors;
        let mut beat = Vec::new();
        let response = chosen.map(|k| {
            let Pending { tag, block, is_missing, beat: number, .. } = &self.pending[k];
            beat.extend(&block[number * self.beat_bytes..][..self.beat_bytes]);
            Response { tag: *tag, is_error: is_error || *is_missing, beat: &beat }
        });
        let inputs = UnitInputs { ray, hit_ready, request_ready, response };
        engines.iter_mut().for_each(|engine| engine.cycle(&inputs));
        self.now += 1;

        if let Some(k) = chosen {
            self.pending[k].beat += 1;
            if self.pending[k].beat * self.beat_bytes == BLOCK_BYTES as usize {
                self.pending.swap_remove(k);
            }
        }
        if outputs.ray_ready && ray.is_some() {
            self.next += 1;
            self.offers = false;
        }
        if let (Some((id, reply)), true) = (outputs.hit, hit_ready) {
            let is_known = id < self.next as u64;
            if !is_known || self.replies.insert(id, reply).is_some() {
                return Err(ProtocolError::End { id, cycle });
            }
        }
        if let (Some(BlockRequest { address, tag }), true) = (outputs.request, request_ready) {
            if self.pending.iter().any(|pending| pending.tag == tag) {
                return Err(ProtocolError::Tag { tag, cycle });
            }
            let (least, greatest) = self.behaviour.latency;
            let found = self.scene.block(address);
            self.pending.push(Pending {
                due: cycle + self.random.random_range(least..=greatest),
                tag,
                block: *found.unwrap_or(&[0xff; BLOCK_BYTES as usize]),
                is_missing: found.is_err(),
                beat: 0,
            });
        }
        Ok(())
    }
}
