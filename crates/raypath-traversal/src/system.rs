//! Units with what is around them: a cluster with its cache, a memory with its limits, and a user that sends rays.

mod arbiter;
mod cache;
#[cfg(test)]
mod lockstep;
pub mod rtl;

use crate::cycle::UnitCounts;
use crate::cycle::ahead::AheadContexts;
use crate::cycle::timing::{Edge, Timing};
use crate::engine::BlockRequest;
use crate::engine::SearchInputs;
use crate::hardware::UnitParameters;
use crate::model::{Memory, RayRequest, Reply};
pub use arbiter::Arbiter;
pub use cache::{Cache, CacheBeat, CacheCounts, CacheEdge, CacheError, CacheParameters, Stored};
use raypath_model::Shape;
use std::collections::VecDeque;
use std::mem::take;
use thiserror::Error;

/// What is around the units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SystemParameters {
    /// The units of the cluster, 1 to 64.
    pub units: u32,
    /// A cache of each unit.
    pub cache: Option<CacheParameters>,
    /// A cache that all units share, behind those of the units.
    pub shared: Option<CacheParameters>,
    /// Cycles from the acceptance of a request by the memory to the first beat, at least 1.
    pub latency: u64,
    /// The bytes that arrive from the memory in a cycle, at least 1; `None` for no limit but that of the port.
    pub bandwidth: Option<u32>,
}

impl SystemParameters {
    /// One unit, at a memory of this latency without other limits.
    pub const fn of_latency(latency: u64) -> Self {
        Self { units: 1, cache: None, shared: None, latency, bandwidth: None }
    }

    /// Checks the parameters for units with these.
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn check(&self, unit: UnitParameters) -> Result<(), SystemError> {
        let Self { units, cache, shared, latency, bandwidth } = *self;
        let numbers = [
            ("units", units.into(), 1..=MAX_UNITS),
            ("cycles of latency", latency, 1..=MAX_LATENCY),
            ("bytes a cycle", bandwidth.map_or(1, u64::from), 1..=MAX_BANDWIDTH),
        ];
        if let Some((name, value, range)) = numbers.into_iter().find(|(_, value, range)| !range.contains(value)) {
            return Err(SystemError::Range { name, value, least: *range.start(), most: *range.end() });
        }
        let mut bytes = unit.step.node.block_bytes();
        for cache in [cache, shared].into_iter().flatten() {
            cache.check(bytes)?;
            bytes = cache.line;
        }
        Ok(())
    }

    /// The bytes of a request of the memory.
    fn request_bytes(&self, unit: UnitParameters) -> u32 {
        self.shared.or(self.cache).map_or(unit.step.node.block_bytes(), |cache| cache.line)
    }
}

/// The most units, cycles of latency and bytes a cycle. Counts of cycles do not overflow.
const MAX_UNITS: u64 = 64;
const MAX_LATENCY: u64 = 1_000_000;
const MAX_BANDWIDTH: u64 = 65_536;

/// The error of a system that cannot be.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum SystemError {
    /// A number out of its range.
    #[error("a system with {value} {name}, expected {least} to {most}")]
    Range {
        /// What it counts.
        name: &'static str,
        /// The number.
        value: u64,
        /// The least number.
        least: u64,
        /// The greatest number.
        most: u64,
    },
    /// The cache.
    #[error(transparent)]
    Cache(#[from] CacheError),
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
    /// What the units did, in all.
    pub unit: UnitCounts,
    /// The beats of the memory.
    pub beats: u64,
    /// What the caches of the units did, in all; 0 without.
    pub cache: CacheCounts,
    /// What the shared cache did; 0 without one.
    pub shared: CacheCounts,
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

/// Simulates the cycle-exact model of a cluster of units, whose datapaths have this shape, until the user has no rays left
/// and all have ended. Hits are taken at once, and candidates have the verdict of
/// [`Verdict::without_shaders`](crate::Verdict::without_shaders) in the next cycle.
pub fn simulate<M: Memory + ?Sized>(
    shape: &Shape,
    unit: UnitParameters,
    scene: &M,
    system: &SystemParameters,
    user: &mut impl RayUser,
) -> SystemTiming {
    let mut cluster = Cluster::new(shape, unit, scene, system);
    let mut memory = Port::new(unit, system);
    let mut timing = SystemTiming::default();
    let (mut now, mut in_flight) = (0, 0);
    let mut ray = None;
    loop {
        if ray.is_none() {
            ray = user.next_ray();
        }
        if cluster.is_still(ray.is_some()) {
            let skipped = memory.next_due().saturating_sub(now);
            if memory.next_due() != NEVER && skipped > 0 {
                cluster.skip(skipped);
                timing.ray_cycles += in_flight * skipped;
                now += skipped;
                continue;
            }
        }
        let beat = memory.beat(scene, now);
        timing.beats += u64::from(beat.is_some());
        timing.ray_cycles += in_flight;
        now += 1;
        let Moved { enters, hit, request } = cluster.cycle(ray.as_ref(), beat, true, true);
        if let Some(request) = request {
            memory.request(request, now);
        }
        if let Some((number, reply)) = hit {
            in_flight -= 1;
            if !user.receive(number, &reply) {
                timing.is_stopped = true;
                break;
            }
        }
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
    timing.unit = cluster.counts();
    let caches = cluster.units.iter().filter_map(|unit| unit.cache.as_ref()).map(Cache::counts);
    timing.cache = caches.reduce(CacheCounts::and).unwrap_or_default();
    timing.shared = cluster.shared.as_ref().map(Cache::counts).unwrap_or_default();
    timing
}

/// The units of a cluster, in a scene that is known, with the cache that they share.
struct Cluster<'s, M: ?Sized> {
    units: Vec<Unit<'s, M>>,
    /// The bits of a context or of a miss in a tag, below those of the unit.
    tag_bits: u32,
    /// Which unit gets a ray, and whose request, hit and candidate is next.
    of_rays: Arbiter,
    of_requests: Arbiter,
    of_hits: Arbiter,
    of_candidates: Arbiter,
    shared: Option<Cache>,
    beats: u32,
}

/// A unit with its cache, with the beats of each block that have arrived and whether one had an error.
struct Unit<'s, M: ?Sized> {
    timing: Timing,
    contexts: AheadContexts<'s, M>,
    cache: Option<Cache>,
    arrived: Vec<(u32, bool)>,
    /// The candidate that was taken in the last cycle: its verdict comes in this one.
    decided: Option<u8>,
}

/// What enters and leaves a cluster in a cycle.
struct Moved {
    /// The ray is accepted.
    enters: bool,
    hit: Option<(u64, Reply)>,
    request: Option<BlockRequest>,
}

impl<'s, M: Memory + ?Sized> Cluster<'s, M> {
    fn new(shape: &Shape, unit: UnitParameters, scene: &'s M, system: &SystemParameters) -> Self {
        let block_bytes = unit.step.node.block_bytes();
        let least = system.cache.map_or(unit.contexts, |cache| cache.misses);
        let tag_bits = least.next_power_of_two().trailing_zeros();
        let one = |_| Unit {
            timing: Timing::new(shape, unit),
            contexts: AheadContexts::new(unit.step, scene, unit.contexts),
            cache: system.cache.map(|cache| Cache::new(cache, block_bytes, unit.memory_width, unit.contexts)),
            arrived: vec![(0, false); unit.contexts as usize],
            decided: None,
        };
        let requested = system.cache.map_or(block_bytes, |cache| cache.line);
        let requesters = system.units << tag_bits;
        let shared = system.shared.map(|cache| Cache::new(cache, requested, unit.memory_width, requesters));
        let [of_rays, of_requests, of_hits, of_candidates] = [Arbiter::default(); 4];
        Self {
            units: (0..system.units).map(one).collect(),
            tag_bits,
            of_rays,
            of_requests,
            of_hits,
            of_candidates,
            shared,
            beats: 8 * block_bytes / unit.memory_width,
        }
    }

    /// Whether a cycle changes nothing but time, if no beat arrives.
    #[inline]
    fn is_still(&self, has_ray: bool) -> bool {
        let are_still = |cache: &Option<Cache>| cache.as_ref().is_none_or(Cache::is_still);
        let is_still = |Unit { timing, contexts, cache, decided, .. }: &Unit<'s, M>| {
            let is_quiet = timing.hit().is_none() & timing.request(contexts).is_none() & timing.candidate().is_none();
            let is_quiet = is_quiet && decided.is_none() && !(has_ray && timing.ray_ready());
            is_quiet && are_still(cache) && timing.is_still()
        };
        are_still(&self.shared) && self.units.iter().all(is_still)
    }

    /// As many cycles that change nothing.
    fn skip(&mut self, cycles: u64) {
        self.units.iter_mut().for_each(|unit| unit.timing.skip(cycles));
    }

    /// What the units did: sums, but for the cycles, which are the same for all.
    fn counts(&self) -> UnitCounts {
        let counts = self.units.iter().map(|unit| unit.timing.counts());
        counts.reduce(UnitCounts::beside).unwrap_or_default()
    }

    /// The clock edge. Candidates are taken, and hits and requests where they can be.
    #[inline(always)]
    fn cycle(
        &mut self,
        ray: Option<&(u64, RayRequest)>,
        beat: Option<Beat>,
        hit_ready: bool,
        request_ready: bool,
    ) -> Moved {
        let word = |is_there: &dyn Fn(&Unit<'s, M>) -> bool| -> u64 {
            self.units.iter().zip(0..).fold(0, |word, (unit, place)| word | u64::from(is_there(unit)) << place)
        };
        let entered = self.of_rays.grant(word(&|unit| unit.timing.ray_ready()));
        let asked = self.of_requests.grant(word(&|unit| unit.lower_request().is_some()));
        let ended = self.of_hits.grant(word(&|unit| unit.timing.hit().is_some()));
        let shown = self.of_candidates.grant(word(&|unit| unit.timing.candidate().is_some()));
        let of_unit = |grant: u64| (grant != 0).then(|| grant.trailing_zeros() as usize);
        let hit = of_unit(ended).and_then(|place| self.units[place].timing.hit());
        let request = of_unit(asked).and_then(|place| {
            let BlockRequest { address, tag } = self.units[place].lower_request()?;
            Some(BlockRequest { address, tag: (place as u32) << self.tag_bits | tag })
        });
        let (beat, is_ready, request) = match &mut self.shared {
            None => (beat, request_ready, request),
            Some(cache) => {
                let is_ready = cache.ready();
                let (response, line) = through(cache, request, request_ready, beat);
                (response, is_ready, line)
            }
        };
        self.of_rays.edge(entered, ray.is_some());
        self.of_requests.edge(asked, is_ready);
        self.of_hits.edge(ended, hit_ready);
        self.of_candidates.edge(shown, true);
        for (unit, place) in self.units.iter_mut().zip(0..) {
            let is_granted = |grant: u64| grant >> place & 1 == 1;
            let low = (1 << self.tag_bits) - 1;
            let of_unit = beat.filter(|beat| beat.tag >> self.tag_bits == place);
            let of_unit = of_unit.map(|beat| Beat { tag: beat.tag & low, ..beat });
            let is_taken = is_granted(asked) && is_ready;
            let (beat, request_ready) = match &mut unit.cache {
                None => (of_unit, is_taken),
                Some(cache) => {
                    let is_ready = cache.ready();
                    (through(cache, unit.timing.request(&unit.contexts), is_taken, of_unit).0, is_ready)
                }
            };
            let arrived = beat.and_then(|beat| unit.arrive(beat, self.beats));
            let candidate = unit.timing.candidate().filter(|_| is_granted(shown));
            unit.timing.cycle(
                &mut unit.contexts,
                &Edge {
                    flush: false,
                    ray: ray.filter(|_| is_granted(entered)),
                    hit_ready: hit_ready & is_granted(ended),
                    candidate_ready: is_granted(shown),
                    decided: take(&mut unit.decided),
                    request_ready,
                    arrived,
                    search: &SearchInputs::default(),
                },
            );
            unit.decided = candidate;
        }
        Moved { enters: entered != 0 && ray.is_some(), hit, request }
    }
}

impl<M: Memory + ?Sized> Unit<'_, M> {
    /// The request that leaves the unit, or its cache.
    #[inline]
    fn lower_request(&self) -> Option<BlockRequest> {
        match &self.cache {
            None => self.timing.request(&self.contexts),
            Some(cache) => cache.request().map(|(address, tag)| BlockRequest { address, tag }),
        }
    }

    /// A beat arrives. Returns its context if it is the last of its block.
    #[inline]
    fn arrive(&mut self, Beat { tag, is_error }: Beat, of_block: u32) -> Option<u8> {
        let (beats, failed) = &mut self.arrived[tag as usize];
        (*beats, *failed) = (*beats + 1, *failed | is_error);
        if *beats < of_block {
            return None;
        }
        self.contexts.arrive(tag as u8, *failed);
        self.arrived[tag as usize] = (0, false);
        Some(tag as u8)
    }
}

/// A cycle of a cache: the beat and the request that leave it.
fn through(
    cache: &mut Cache,
    request: Option<BlockRequest>,
    memory_ready: bool,
    beat: Option<Beat>,
) -> (Option<Beat>, Option<BlockRequest>) {
    let (response, line) = (cache.response(), cache.request());
    cache.cycle(&CacheEdge {
        invalidates: false,
        request: request.map(|request| (request.address, request.tag)),
        memory_ready,
        beat: beat.map(|beat| (beat.tag, beat.is_error)),
    });
    let response = response.map(|CacheBeat { tag, is_error, .. }| Beat { tag, is_error });
    (response, line.map(|(address, tag)| BlockRequest { address, tag }))
}

/// A cycle that is never reached.
const NEVER: u64 = u64::MAX;

/// The memory with the requests in it, which it answers in order.
struct Port {
    /// The bytes of a request, and its beats.
    bytes: u32,
    beats: u32,
    /// The bytes that must exist, from the address of a request on.
    block_bytes: u32,
    latency: u64,
    bandwidth: Option<u32>,
    /// The cycle from which the next bytes can arrive, times the bandwidth.
    free_from: u64,
    /// Requests with the cycle of their first beat.
    waiting: VecDeque<(u64, BlockRequest)>,
    arriving: Beat,
    /// The beats of it that have not yet arrived.
    left: u32,
}

/// A beat of the memory, or of the cache.
#[derive(Clone, Copy, Default)]
struct Beat {
    tag: u32,
    is_error: bool,
}

impl Port {
    fn new(unit: UnitParameters, system: &SystemParameters) -> Self {
        let (block_bytes, bytes) = (unit.step.node.block_bytes(), system.request_bytes(unit));
        Self {
            bytes,
            beats: (8 * bytes).div_ceil(unit.memory_width),
            block_bytes,
            latency: system.latency,
            bandwidth: system.bandwidth,
            free_from: 0,
            waiting: VecDeque::new(),
            arriving: Beat::default(),
            left: 0,
        }
    }

    /// A request that was accepted in the cycle before `now`.
    #[inline]
    fn request(&mut self, request: BlockRequest, now: u64) {
        let due = self.transfer(now) - 1;
        self.waiting.push_back((due, request));
    }

    /// The cycle in which the bytes of a request have arrived.
    #[inline]
    fn transfer(&mut self, now: u64) -> u64 {
        let Some(bandwidth) = self.bandwidth.map(u64::from) else { return now + self.latency };
        let begin = self.free_from.max(now * bandwidth);
        self.free_from = begin + u64::from(self.bytes);
        // The latency includes the transfer of one request.
        let alone = u64::from(self.bytes).div_ceil(bandwidth);
        self.free_from.div_ceil(bandwidth) + self.latency.saturating_sub(alone)
    }

    /// The cycle of the next beat; `NEVER` if nothing is requested.
    #[inline]
    fn next_due(&self) -> u64 {
        if self.left > 0 { 0 } else { self.waiting.front().map_or(NEVER, |(due, _)| *due) }
    }

    /// The beat of this cycle.
    #[inline]
    fn beat<M: Memory + ?Sized>(&mut self, scene: &M, now: u64) -> Option<Beat> {
        if self.next_due() > now {
            return None;
        }
        if self.left == 0 {
            let (_, BlockRequest { address, tag }) = self.waiting.pop_front()?;
            let is_error = scene.block(address, self.block_bytes).is_err();
            (self.arriving, self.left) = (Beat { tag, is_error }, self.beats);
        }
        self.left -= 1;
        Some(self.arriving)
    }
}
