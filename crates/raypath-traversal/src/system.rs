//! A system around the cycle-exact model: a memory with its limits, and a user that sends rays.

mod cache;

use crate::cycle::UnitCounts;
use crate::cycle::ahead::AheadContexts;
use crate::cycle::timing::{Edge, Timing};
use crate::engine::BlockRequest;
use crate::hardware::UnitParameters;
use crate::model::{Memory, RayRequest, Reply};
use cache::Cache;
pub use cache::{CacheError, CacheParameters};
use raypath_model::Shape;
use std::collections::VecDeque;
use std::mem::replace;

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
        self.unit.boxes + self.unit.triangles + self.unit.transforms
    }

    /// The mean number of cycles that a ray is in flight for each of its fetches.
    pub fn cycles_per_fetch(&self) -> f64 {
        self.ray_cycles as f64 / self.unit.fetches.max(1) as f64
    }
}

/// Simulates the cycle-exact model of a unit, whose datapath has this shape, until the user has no rays left and all
/// have ended. Hits are taken at once, and candidates have the verdict of
/// [`Verdict::without_shaders`](crate::Verdict::without_shaders) in the next cycle.
pub fn simulate<M: Memory + ?Sized>(
    shape: &Shape,
    unit: UnitParameters,
    scene: &M,
    memory: &MemoryParameters,
    user: &mut impl RayUser,
) -> SystemTiming {
    let mut contexts = AheadContexts::new(unit.step, scene, unit.contexts);
    let mut memory = Port::new(unit, memory);
    let mut unit = Timing::new(shape, unit);
    let mut timing = SystemTiming::default();
    let (mut now, mut in_flight) = (0, 0);
    // The verdict on a candidate comes in the cycle after it is taken.
    let (mut ray, mut decided) = (None, None);
    loop {
        if ray.is_none() {
            ray = user.next_ray();
        }
        let beat = memory.beat(scene, now);
        let (hit, request, candidate) = (unit.hit(), unit.request(&contexts), unit.candidate());
        let enters = ray.is_some() & unit.ray_ready();
        let is_quiet = !enters & hit.is_none() & request.is_none() & candidate.is_none() & beat.is_none();
        let due = memory.next_due();
        if is_quiet && decided.is_none() && due != NEVER {
            let skipped = unit.idle(due.saturating_sub(now));
            if skipped > 0 {
                timing.ray_cycles += in_flight * skipped;
                now += skipped;
                continue;
            }
        }
        timing.beats += u64::from(beat.is_some());
        timing.ray_cycles += in_flight;
        now += 1;
        if let Some((number, reply)) = hit {
            in_flight -= 1;
            if !user.receive(number, &reply) {
                timing.is_stopped = true;
                break;
            }
        }
        if let Some(request) = request {
            memory.request(request, now);
        }
        let arrived = beat.filter(|beat| beat.is_last).map(|beat| {
            contexts.arrive(beat.context, beat.is_error);
            beat.context
        });
        unit.cycle(
            &mut contexts,
            &Edge {
                flush: false,
                ray: ray.as_ref().filter(|_| enters),
                hit_ready: true,
                candidate_ready: true,
                decided: replace(&mut decided, candidate),
                request_ready: true,
                arrived,
            },
        );
        if enters {
            ray = None;
            in_flight += 1;
        }
        if in_flight == 0 && ray.is_none() {
            ray = user.next_ray();
            if ray.is_none() {
                break;
            }
        }
    }
    timing.unit = unit.counts();
    (timing.cache_hits, timing.cache_misses) = memory.cache.as_ref().map_or((0, 0), Cache::counts);
    timing
}

/// A cycle that is never reached.
const NEVER: u64 = u64::MAX;

/// The memory with the requests in it.
struct Port {
    /// The beats of a block.
    beats: u32,
    block_bytes: u32,
    latency: u64,
    bandwidth: Option<u32>,
    cache: Option<Cache>,
    /// The cycle from which the next bytes can arrive from behind the cache, times the bandwidth.
    free_from: u64,
    /// Requests with the cycle of their first beat: in the order of these cycles, then by age.
    waiting: VecDeque<(u64, BlockRequest)>,
    /// The cycles of the first of them and of the last; `NEVER` and 0 if there is none.
    first_due: u64,
    last_due: u64,
    arriving: Arriving,
}

/// The block whose beats arrive.
#[derive(Default)]
struct Arriving {
    context: u8,
    is_error: bool,
    /// The beats that have not yet arrived.
    beats: u32,
}

/// A beat of a block.
#[derive(Clone, Copy)]
struct Beat {
    context: u8,
    is_error: bool,
    is_last: bool,
}

impl Port {
    fn new(unit: UnitParameters, parameters: &MemoryParameters) -> Self {
        let block_bytes = unit.step.node.block_bytes();
        Self {
            beats: (8 * block_bytes).div_ceil(unit.memory_width),
            block_bytes,
            latency: parameters.latency,
            bandwidth: parameters.bandwidth,
            cache: parameters.cache.map(Cache::new),
            free_from: 0,
            waiting: VecDeque::new(),
            first_due: NEVER,
            last_due: 0,
            arriving: Arriving::default(),
        }
    }

    /// A request that was accepted in the cycle before `now`.
    #[inline]
    fn request(&mut self, request: BlockRequest, now: u64) {
        let (line, hit_latency) = self.cache.as_ref().map_or((self.block_bytes, 0), Cache::line);
        let misses = self.cache.as_mut().map_or(1, |cache| cache.misses(request.address, self.block_bytes));
        let due = if misses == 0 { now + hit_latency } else { self.transfer(misses * line, now) } - 1;
        if due >= self.last_due {
            self.waiting.push_back((due, request));
            self.last_due = due;
        } else {
            // A request that the cache has overtakes others.
            let place = self.waiting.partition_point(|(other, _)| *other <= due);
            self.waiting.insert(place, (due, request));
        }
        self.first_due = self.first_due.min(due);
    }

    /// The cycle in which these bytes have arrived from behind the cache.
    #[inline]
    fn transfer(&mut self, bytes: u32, now: u64) -> u64 {
        let Some(bandwidth) = self.bandwidth.map(u64::from) else { return now + self.latency };
        let begin = self.free_from.max(now * bandwidth);
        self.free_from = begin + u64::from(bytes);
        // The latency includes the transfer of one block.
        let alone = u64::from(bytes).div_ceil(bandwidth);
        self.free_from.div_ceil(bandwidth) + self.latency.saturating_sub(alone)
    }

    /// The cycle of the next beat; `NEVER` if nothing is requested.
    #[inline]
    fn next_due(&self) -> u64 {
        if self.arriving.beats == 0 { self.first_due } else { 0 }
    }

    /// The beat of this cycle.
    #[inline]
    fn beat<M: Memory + ?Sized>(&mut self, scene: &M, now: u64) -> Option<Beat> {
        if self.arriving.beats == 0 {
            if self.first_due > now {
                return None;
            }
            self.arriving = self.next_block(scene)?;
        }
        let Arriving { context, is_error, beats } = &mut self.arriving;
        *beats -= 1;
        Some(Beat { context: *context, is_error: *is_error, is_last: *beats == 0 })
    }

    /// The block of the next request.
    #[inline]
    fn next_block<M: Memory + ?Sized>(&mut self, scene: &M) -> Option<Arriving> {
        let (_, BlockRequest { address, tag }) = self.waiting.pop_front()?;
        self.first_due = self.waiting.front().map_or(NEVER, |(due, _)| *due);
        let is_error = scene.block(address, self.block_bytes).is_err();
        Some(Arriving { context: tag as u8, is_error, beats: self.beats })
    }
}
