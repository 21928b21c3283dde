//! A system around the cycle-exact model: a memory with its limits, and a user that sends rays.

mod cache;

use crate::blocks::BLOCK_BYTES;
use crate::cycle::{UnitCounts, UnitModel};
use crate::engine::{BlockRequest, Response, UnitEngine, UnitInputs};
use crate::model::{Memory, RayRequest, Reply};
use cache::Cache;
pub use cache::{CacheError, CacheParameters};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The memory behind the unit's port.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MemoryParameters {
    /// Cycles from the acceptance of a request to the first beat of its block, at least 1; of a request that the cache
    /// does not have, if there is one.
    pub latency: u64,
    /// The bytes that arrive from behind the cache in a cycle, at least 1; `None` for no limit but that of the port.
    pub bandwidth: Option<u32>,
    /// A cache before the memory.
    pub cache: Option<CacheParameters>,
}

/// The user of the unit.
pub trait RayUser {
    /// The next ray, with a number for its reply, if one can begin now.
    fn next_ray(&mut self) -> Option<(u64, RayRequest)>;
    /// Takes the reply of a ray. Returns false to stop the simulation.
    fn receive(&mut self, number: u64, reply: &Reply) -> bool;
}

/// What a simulation measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SystemTiming {
    /// What the unit did.
    pub unit: UnitCounts,
    /// The beats of the memory.
    pub beats: u64,
    /// The requests that the cache had.
    pub cache_hits: u64,
    /// The requests that the cache did not have; 0 without a cache.
    pub cache_misses: u64,
    /// The sum over all cycles of the rays in flight.
    pub ray_cycles: u64,
    /// The user stopped the simulation.
    pub is_stopped: bool,
}

impl SystemTiming {
    /// The jobs of the datapath for each cycle.
    pub fn jobs_per_cycle(&self) -> f64 {
        self.jobs() as f64 / self.unit.cycles.max(1) as f64
    }

    /// The jobs of the datapath.
    pub fn jobs(&self) -> u64 {
        self.unit.boxes + self.unit.triangles
    }

    /// The mean number of cycles that a ray is in flight for each of its fetches.
    pub fn cycles_per_fetch(&self) -> f64 {
        self.ray_cycles as f64 / self.unit.fetches.max(1) as f64
    }
}

/// Simulates the unit until the user has no rays left and all have ended. Hits are taken at once.
pub fn simulate<M: Memory + ?Sized>(
    unit: &mut UnitModel,
    scene: &M,
    parameters: &MemoryParameters,
    user: &mut impl RayUser,
) -> SystemTiming {
    let mut memory = Port::new(unit.beat_bytes(), parameters);
    let mut timing = SystemTiming::default();
    let mut offered = None;
    let (mut now, mut in_flight) = (0, 0);
    loop {
        offered = offered.or_else(|| user.next_ray());
        let outputs = unit.outputs();
        let response = memory.response(scene, now);
        let inputs = UnitInputs { ray: offered, hit_ready: true, request_ready: true, response };
        let is_quiet = outputs.hit.is_none()
            && outputs.request.is_none()
            && response.is_none()
            && (offered.is_none() || !outputs.ray_ready);
        timing.beats += u64::from(response.is_some());
        unit.cycle(&inputs);
        timing.ray_cycles += in_flight;
        now += 1;
        if outputs.ray_ready && offered.take_if(|_| true).is_some() {
            in_flight += 1;
        }
        if let Some(request) = outputs.request {
            memory.request(request, now);
        }
        if let Some((number, reply)) = outputs.hit {
            in_flight -= 1;
            if !user.receive(number, &reply) {
                timing.is_stopped = true;
                break;
            }
        }
        if in_flight == 0 && offered.is_none() {
            offered = user.next_ray();
            if offered.is_none() {
                break;
            }
        }
        if is_quiet && let Some(due) = memory.next_due() {
            let skipped = unit.idle(due.saturating_sub(now));
            timing.ray_cycles += in_flight * skipped;
            now += skipped;
        }
    }
    timing.unit = unit.counts();
    (timing.cache_hits, timing.cache_misses) = memory.cache.as_ref().map_or((0, 0), Cache::counts);
    timing
}

/// The memory with the requests in it.
struct Port {
    beat_bytes: usize,
    latency: u64,
    bandwidth: Option<u32>,
    cache: Option<Cache>,
    /// The cycle from which the next bytes can arrive from behind the cache, times the bandwidth.
    free_from: u64,
    /// Requests by the cycle of their first beat, then by age.
    waiting: BinaryHeap<Reverse<(u64, u64, u32, u32)>>,
    age: u64,
    /// The block whose beats arrive, and the bytes that have arrived.
    arriving: Option<(BlockRequest, usize)>,
}

impl Port {
    fn new(beat_bytes: usize, parameters: &MemoryParameters) -> Self {
        Self {
            beat_bytes,
            latency: parameters.latency,
            bandwidth: parameters.bandwidth,
            cache: parameters.cache.map(Cache::new),
            free_from: 0,
            waiting: BinaryHeap::new(),
            age: 0,
            arriving: None,
        }
    }

    /// A request that was accepted in the cycle before `now`.
    fn request(&mut self, BlockRequest { address, tag }: BlockRequest, now: u64) {
        let (line, hit_latency) = self.cache.as_ref().map_or((BLOCK_BYTES, 0), Cache::line);
        let misses = self.cache.as_mut().map_or(1, |cache| cache.misses(address));
        let due = if misses == 0 { now + hit_latency } else { self.transfer(misses * line, now) } - 1;
        self.waiting.push(Reverse((due, self.age, address, tag)));
        self.age += 1;
    }

    /// The cycle in which these bytes have arrived from behind the cache.
    fn transfer(&mut self, bytes: u32, now: u64) -> u64 {
        let Some(bandwidth) = self.bandwidth.map(u64::from) else { return now + self.latency };
        let begin = self.free_from.max(now * bandwidth);
        self.free_from = begin + u64::from(bytes);
        // The latency includes the transfer of one block.
        let alone = u64::from(bytes).div_ceil(bandwidth);
        self.free_from.div_ceil(bandwidth) + self.latency.saturating_sub(alone)
    }

    /// The cycle of the next beat.
    fn next_due(&self) -> Option<u64> {
        if self.arriving.is_some() { Some(0) } else { self.waiting.peek().map(|Reverse((due, ..))| *due) }
    }

    fn response<'s, M: Memory + ?Sized>(&mut self, scene: &'s M, now: u64) -> Option<Response<'s>> {
        if self.arriving.is_none() {
            let Reverse((_, _, address, tag)) = *self.waiting.peek().filter(|Reverse((due, ..))| *due <= now)?;
            self.waiting.pop();
            self.arriving = Some((BlockRequest { address, tag }, 0));
        }
        let (BlockRequest { address, tag }, from) = self.arriving?;
        let to = from + self.beat_bytes;
        self.arriving = (to < BLOCK_BYTES as usize).then_some((BlockRequest { address, tag }, to));
        const NOTHING: &[u8; BLOCK_BYTES as usize] = &[0; BLOCK_BYTES as usize];
        let found = scene.block(address);
        let (block, is_error) = (*found.as_ref().unwrap_or(&NOTHING), found.is_err());
        Some(Response { tag, is_error, beat: block.get(from..to)? })
    }
}
