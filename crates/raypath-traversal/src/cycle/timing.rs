//! The timing of the unit: which context is where in which cycle.

use super::contexts::Contexts;
use super::parts::{Job, Kind, Line, Queues, Ring, Scheduler, Weights};
use super::searches::{Beat, Searches};
use crate::blocks::NodeKind;
use crate::engine::{BlockRequest, SearchInputs};
use crate::hardware::{DECODER_LATENCY, UnitParameters};
use crate::model::{RayRequest, Reply};
use crate::set_up::QUOTIENTS;
use crate::walk::{Asked, AskedKind};
use raypath_model::{Flow, Shape, state};
use std::hint::select_unpredictable;
use std::mem::replace;

/// The timing of the unit. It moves the numbers of contexts through queues and pipelines.
#[derive(Debug, Clone)]
pub struct Timing {
    parameters: UnitParameters,
    /// Rays are dropped.
    flushes: bool,
    /// The contexts from here on were never used.
    fresh: u32,
    queues: Queues<QUEUES>,
    /// Cycles until the next ray can enter the set-up.
    busy: u32,
    /// A ray entered an instance in the last turn of the set-up, so that a new ray has the next one.
    yields: bool,
    /// The rays whose quotients are divided.
    set_up: Line<u8>,
    /// The job that is offered to the datapath, and how many jobs of its block follow it.
    offer: Job,
    has_offer: bool,
    following: u32,
    /// With compressed nodes: the jobs of blocks whose boxes are decoded.
    decoder: Option<Line<Job>>,
    /// With searches.
    pub searches: Option<Searches>,
    flow: Flow,
    /// The jobs in the datapath.
    jobs: Ring<Job, 512>,
    /// The triangle whose distance is divided next.
    operands: Job,
    has_operands: bool,
    divider: Line<Job>,
    /// The triangle whose limits are read.
    triangle: Job,
    has_triangle: bool,
    scheduler: Scheduler,
    /// The steps in progress, each at the cycle in which its answer was chosen, modulo the cycles of a step.
    steps: [Answered; 4],
    /// With barycentric coordinates, which are divided before a hit is shown.
    weights: Option<Weights>,
    hit: Option<(u64, Reply)>,
    /// The context whose candidate is at the port.
    candidate: Option<u8>,
    cycles: u64,
    /// With searches: no ray is inside, and nothing of the last one moves, so that only searches have edges.
    is_quiet: bool,
    /// The jobs of each kind.
    offered: [u64; Kind::COUNT],
    /// The steps of each kind of request.
    asked: [u64; AskedKind::COUNT],
    /// The descents that began again at the root.
    restarts: u64,
    /// The cycles in which a job waited for the datapath.
    job_stalls: u64,
}

/// What the unit did since its last reset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct UnitCounts {
    /// Cycles.
    pub cycles: u64,
    /// Box jobs.
    pub boxes: u64,
    /// Triangle jobs.
    pub triangles: u64,
    /// Transforms: two for each instance that a ray enters.
    pub transforms: u64,
    /// Steps.
    pub steps: u64,
    /// Blocks that were requested.
    pub fetches: u64,
    /// Rays that ended.
    pub rays: u64,
    /// Descents that began again at the root, because the stack had lost a level.
    pub restarts: u64,
    /// Cycles in which a job waited for the datapath.
    pub job_stalls: u64,
    /// Candidates about which the user was asked.
    pub candidates: u64,
}

impl UnitCounts {
    /// The sums of what two units did in the same cycles.
    #[must_use]
    pub fn beside(self, other: Self) -> Self {
        Self {
            cycles: self.cycles,
            boxes: self.boxes + other.boxes,
            triangles: self.triangles + other.triangles,
            transforms: self.transforms + other.transforms,
            steps: self.steps + other.steps,
            fetches: self.fetches + other.fetches,
            rays: self.rays + other.rays,
            restarts: self.restarts + other.restarts,
            job_stalls: self.job_stalls + other.job_stalls,
            candidates: self.candidates + other.candidates,
        }
    }
}

/// What enters the unit in a cycle, and what may leave it.
pub struct Edge<'r> {
    /// All rays are dropped from now on.
    pub flush: bool,
    /// A ray that enters, for which [`Timing::ray_ready`] was true, with its number.
    pub ray: Option<&'r (u64, RayRequest)>,
    pub hit_ready: bool,
    pub candidate_ready: bool,
    /// The context for whose candidate a verdict has come.
    pub decided: Option<u8>,
    pub request_ready: bool,
    /// The context whose block has arrived with the beat of this cycle.
    pub arrived: Option<u8>,
    pub search: &'r SearchInputs<'r>,
}

/// A step of a context, by the source of its answer; none if the source is 0.
#[derive(Debug, Clone, Copy, Default)]
struct Answered {
    context: u8,
    source: u32,
}

// The numbers of the queues. Those of answers come first, in the order of `hardware::SOURCES`.
const TESTED: usize = 0;
/// The context with the closest hit of a block.
const CLOSEST: usize = 1;
/// The context whose block failed.
const FAULT: usize = 2;
const STARTS: usize = 3;
const AGAINS: usize = 4;
/// The context for whose candidate a verdict has come.
const DECIDED: usize = 5;
const FREE: usize = 6;
const ARRIVALS: usize = 7;
const REQUESTS: usize = 8;
const ENDED: usize = 9;
/// The context that asks about a candidate.
const CANDIDATES: usize = 10;
const QUEUES: usize = 11;

/// Cycles between two looks whether rays are quiet.
const CYCLES_TO_QUIET: u64 = 64;

/// The sources of answers, a bit for each.
const SOURCES: u32 = (1 << FREE) - 1;

state! {
    Answered { context, source }
    Timing {
        fresh, queues, busy, yields, set_up, offer, has_offer, following, flow, jobs, operands, has_operands, divider,
        triangle, has_triangle, scheduler, steps, hit, candidate, cycles, offered, asked,
        restarts, job_stalls, flushes, is_quiet | decoder, weights, searches
    }
}

impl Timing {
    /// The timing of a unit after a reset, whose datapath has this shape.
    pub fn new(shape: &Shape, parameters: UnitParameters) -> Self {
        let features = parameters.step.features;
        Self {
            parameters,
            flushes: false,
            fresh: 0,
            queues: Queues::new(),
            busy: 0,
            yields: false,
            // The operands of the last quotient enter a register, then the divider.
            set_up: Line::new(QUOTIENTS as u32 + 1 + parameters.divider_latency),
            offer: Job::default(),
            has_offer: false,
            following: 0,
            decoder: parameters.step.has_decoder().then(|| Line::new(DECODER_LATENCY)),
            searches: parameters.search.0.map(|search| Searches::new(search, parameters.search_ports())),
            flow: Flow::new(shape),
            jobs: Ring::new(),
            operands: Job::default(),
            has_operands: false,
            divider: Line::new(parameters.divider_latency),
            triangle: Job::default(),
            has_triangle: false,
            scheduler: Scheduler::default(),
            steps: [Answered::default(); 4],
            weights: features.barycentrics.then(|| Weights::new(parameters.divider_latency)),
            hit: None,
            candidate: None,
            cycles: 0,
            is_quiet: false,
            offered: [0; Kind::COUNT],
            asked: [0; AskedKind::COUNT],
            restarts: 0,
            job_stalls: 0,
        }
    }

    /// What the unit did since its last reset.
    pub fn counts(&self) -> UnitCounts {
        let jobs = |kinds: [Kind; 2]| kinds.map(|kind| self.offered[kind as usize]).into_iter().sum();
        UnitCounts {
            cycles: self.cycles,
            boxes: jobs([Kind::Half, Kind::Node]),
            triangles: jobs([Kind::Triangle, Kind::LastTriangle]),
            transforms: jobs([Kind::Origin, Kind::Direction]),
            steps: self.asked.iter().sum(),
            fetches: self.asked[AskedKind::Block as usize],
            rays: self.asked[AskedKind::Nothing as usize],
            restarts: self.restarts,
            job_stalls: self.job_stalls,
            candidates: self.asked[AskedKind::Verdict as usize],
        }
    }

    /// The ray that has ended, and its reply.
    #[inline]
    pub fn hit(&self) -> Option<(u64, Reply)> {
        self.hit.filter(|_| !self.flushes)
    }

    /// No ray is in the unit.
    pub fn is_idle(&self) -> bool {
        self.queues.count(FREE) == self.fresh && self.hit.is_none()
    }

    /// The context whose candidate is at the port.
    #[inline]
    pub fn candidate(&self) -> Option<u8> {
        self.candidate.filter(|_| !self.flushes)
    }

    /// The request for a block.
    #[inline]
    pub fn request(&self, contexts: &impl Contexts) -> Option<BlockRequest> {
        let context = self.queues.front(REQUESTS)?;
        Some(BlockRequest { address: contexts.address(context), tag: context.into() })
    }

    /// Whether a cycle in which no ray is offered, no response arrives, and nothing is taken changes nothing but time.
    // Within a loop, its many conditions would be computed in every cycle.
    #[inline(never)]
    pub fn is_still(&self) -> bool {
        self.searches.as_ref().is_none_or(Searches::is_idle) && self.jobs.is_empty() && self.are_rays_still()
    }

    fn are_rays_still(&self) -> bool {
        let waiting = SOURCES | 1 << ARRIVALS | 1 << ENDED | 1 << CANDIDATES;
        self.busy == 0
            && self.set_up.is_empty()
            && !self.has_operands
            && self.divider.is_empty()
            && !self.has_triangle
            && !self.has_offer
            && self.decoder.as_ref().is_none_or(Line::is_empty)
            && self.steps.iter().all(|step| step.source == 0)
            && self.queues.are_settled()
            && self.weights.as_ref().is_none_or(Weights::is_empty)
            && self.queues.ready() & waiting == 0
    }

    /// As many cycles that change nothing but time.
    pub fn skip(&mut self, cycles: u64) {
        self.cycles = self.cycles.saturating_add(cycles);
    }

    /// The clock edge.
    #[inline(always)]
    pub fn cycle(&mut self, contexts: &mut impl Contexts, edge: &Edge<'_>) {
        self.is_quiet &= edge.ray.is_none() & !edge.flush;
        if self.is_quiet {
            self.datapath((Job::default(), false), [false; 2], edge.search);
            self.cycles = self.cycles.saturating_add(1);
            return;
        }
        // Each part reads what the parts after it had in registers, because it comes after them.
        let chosen = self.choose();
        let flushes = edge.flush | (self.flushes & !self.is_idle());
        let enters_instance = self.rays(contexts, edge.ray);
        self.hits(contexts, edge.hit_ready | self.flushes);
        self.candidates(edge);
        self.walk(contexts, chosen, edge.request_ready);
        self.jobs(enters_instance, edge.search);
        self.blocks(contexts, edge.arrived);
        self.queues.edge();
        self.flushes = flushes;
        self.cycles = self.cycles.saturating_add(1);
        if self.searches.is_some() && self.cycles.is_multiple_of(CYCLES_TO_QUIET) {
            self.is_quiet = self.is_idle() && !flushes && self.are_rays_still();
        }
    }

    pub fn reset(&mut self) {
        (self.fresh, self.flushes) = (0, false);
        self.searches = self.parameters.search.0.map(|search| Searches::new(search, self.parameters.search_ports()));
        (self.busy, self.yields) = (0, false);
        self.set_up.clear();
        self.queues.clear();
        (self.has_offer, self.has_operands, self.has_triangle, self.hit) = (false, false, false, None);
        self.candidate = None;
        self.steps = [Answered::default(); 4];
        self.flow.reset();
        self.jobs.clear();
        self.divider.clear();
        self.weights.iter_mut().for_each(Weights::clear);
        self.decoder.iter_mut().for_each(Line::clear);
        self.scheduler = Scheduler::default();
        self.is_quiet = false;
        (self.cycles, self.offered, self.asked) = (0, [0; Kind::COUNT], [0; AskedKind::COUNT]);
        (self.restarts, self.job_stalls) = (0, 0);
    }

    #[inline]
    fn has_context(&self) -> bool {
        (self.fresh < self.parameters.contexts) | self.queues.is_ready(FREE)
    }

    #[inline]
    pub fn ray_ready(&self) -> bool {
        (self.busy <= 1) & !self.flushes & self.has_context() && self.transformed().is_none()
    }

    /// The contexts with a ray.
    pub fn occupied(&self) -> impl Iterator<Item = u8> + '_ {
        let is_free = self.queues.has(FREE);
        (0..self.fresh).map(|context| context as u8).filter(move |context| !is_free[usize::from(*context)])
    }

    /// Whether the block of the ray in each context is not yet requested.
    pub fn requesting(&self) -> [bool; 256] {
        self.queues.has(REQUESTS)
    }

    /// The ray that has the next turn of the set-up to enter an instance.
    #[inline]
    fn transformed(&self) -> Option<u8> {
        if !self.parameters.step.features.instances {
            return None;
        }
        let Job { context, kind } = self.jobs.first();
        let waits = kind == Kind::Direction && self.flow.output_valid();
        (waits && !(self.yields && self.has_context())).then_some(context)
    }

    /// Chooses the answer of the next step, and takes it.
    // Here and in the other parts, no branch depends on which queues have words, because that is as random as the
    // traffic.
    #[inline]
    fn choose(&mut self) -> Answered {
        let source = self.scheduler.grant(self.queues.ready() & SOURCES);
        // No source is queue 0, from which nothing is taken.
        let queue = source.trailing_zeros() as usize % FREE.next_power_of_two();
        Answered { context: self.queues.pop_if(queue, source != 0), source }
    }

    /// The edge of the rays that begin, and of those that enter an instance. Returns whether one does.
    #[inline]
    fn rays(&mut self, contexts: &mut impl Contexts, ray: Option<&(u64, RayRequest)>) -> bool {
        let in_instance = self.transformed();
        let is_ready = self.busy <= 1;
        let entered = if in_instance.is_none() {
            ray.map(|(id, ray)| {
                let context = self.free_context();
                contexts.enter(context, *id, ray);
                context
            })
        } else {
            in_instance.filter(|_| is_ready)
        };
        if is_ready {
            self.yields = in_instance.is_some();
        }
        self.busy = if entered.is_some() { QUOTIENTS as u32 } else { self.busy.saturating_sub(1) };
        if let Some(context) = self.set_up.advance(entered) {
            self.queues.push(STARTS, context);
        }
        is_ready && in_instance.is_some()
    }

    /// The context that the next ray enters.
    fn free_context(&mut self) -> u8 {
        if self.fresh < self.parameters.contexts {
            self.fresh += 1;
            (self.fresh - 1) as u8
        } else {
            self.queues.pop(FREE)
        }
    }

    /// The edge of the hits.
    #[inline]
    fn hits(&mut self, contexts: &impl Contexts, ready: bool) {
        let can_show = ready || self.hit.is_none();
        let Some(weights) = &mut self.weights else {
            if can_show {
                self.hit = None;
                if self.queues.is_ready(ENDED) {
                    let context = self.queues.pop(ENDED);
                    self.show(contexts, context);
                }
            }
            return;
        };
        let shown = weights.front().filter(|_| can_show);
        if weights.edge(self.queues.front(ENDED), can_show) {
            self.queues.pop(ENDED);
        }
        if can_show {
            self.hit = None;
        }
        if let Some(context) = shown {
            self.show(contexts, context);
        }
    }

    /// The edge of the candidates.
    #[inline]
    fn candidates(&mut self, edge: &Edge<'_>) {
        if !self.parameters.step.features.has_candidates() {
            return;
        }
        // A candidate of a ray that is dropped is its own verdict.
        let dropped = self.candidate.filter(|_| self.flushes);
        let ready = if self.flushes { edge.decided.is_none() } else { edge.candidate_ready };
        if ready || self.candidate.is_none() {
            self.candidate = self.queues.front(CANDIDATES);
            self.queues.pop_if(CANDIDATES, self.candidate.is_some());
        }
        let decided = edge.decided.or(dropped);
        self.queues.push_if(DECIDED, decided.unwrap_or_default(), decided.is_some());
    }

    /// Shows the hit of a ray, and frees its context.
    fn show(&mut self, contexts: &impl Contexts, context: u8) {
        self.hit = Some(contexts.reply(context));
        self.queues.push(FREE, context);
    }

    /// The edge of the requests and the steps.
    #[inline]
    fn walk(&mut self, contexts: &mut impl Contexts, chosen: Answered, request_ready: bool) {
        self.queues.pop_if(REQUESTS, request_ready & self.queues.is_ready(REQUESTS));
        // A step has two stages, each of the latency of a memory.
        let place = self.cycles & u64::from(2 * self.parameters.ram_latency - 1);
        let Answered { context, source } = replace(&mut self.steps[place as usize % 4], chosen);
        let steps = source != 0;
        let Asked { kind, restarts, .. } = contexts.step(context, steps);
        let asked = if self.flushes { AskedKind::Nothing } else { kind };
        let queue = match asked {
            AskedKind::Block => REQUESTS,
            AskedKind::Again | AskedKind::Begin => AGAINS,
            AskedKind::Nothing => ENDED,
            AskedKind::Verdict => CANDIDATES,
        };
        self.queues.push_if(queue, context, steps);
        self.asked[asked as usize] += u64::from(steps);
        self.restarts += u64::from(steps & restarts);
    }

    /// The edge of the distances of triangles. Returns whether an outcome can be taken.
    #[inline]
    fn distances(&mut self) -> bool {
        let reads = self.has_triangle & !self.queues.is_ready(CLOSEST);
        if reads & (self.triangle.kind == Kind::LastTriangle) {
            self.queues.put(CLOSEST, self.triangle.context);
        }
        self.has_triangle &= !reads;
        let is_divided = self.divider.has_last();
        if !(self.has_triangle & is_divided) {
            let divided = self.divider.advance_if(self.operands, self.has_operands);
            self.triangle = select_unpredictable(is_divided, divided, self.triangle);
            self.has_triangle |= is_divided;
            self.has_operands = false;
        }
        !self.has_operands
    }

    /// The edge of the datapath.
    #[inline]
    fn jobs(&mut self, enters_instance: bool, search: &SearchInputs<'_>) {
        let takes_triangle = self.distances();
        let (ready, has_ready) = match &self.decoder {
            None => (self.offer, self.has_offer),
            Some(decoder) => (decoder.first(), decoder.has_last()),
        };
        let leaves = self.datapath((ready, has_ready), [takes_triangle, enters_instance], search);
        self.job_stalls += u64::from(has_ready & !leaves);
        self.offered[ready.kind as usize] += u64::from(leaves);
        let issues = match &mut self.decoder {
            None => leaves,
            Some(decoder) => {
                let advances = leaves | !has_ready;
                if advances {
                    decoder.advance(self.has_offer.then_some(self.offer));
                }
                advances & self.has_offer
            }
        };
        let follows = self.following > 0;
        let next = self.offer.kind.next(self.following == 1);
        self.offer.kind = select_unpredictable(issues, next, self.offer.kind);
        self.has_offer = select_unpredictable(issues, follows, self.has_offer);
        self.following -= u32::from(issues & follows);
    }

    /// The edge of the datapath itself, at which a job of a ray may be ready. Returns whether that leaves.
    #[inline(always)]
    fn datapath(
        &mut self,
        (ready, has_ready): (Job, bool),
        [takes_triangle, enters_instance]: [bool; 2],
        search: &SearchInputs<'_>,
    ) -> bool {
        let outcome = self.jobs.first();
        let outcome_leaves = self.flow.output_valid() & outcome.kind.is_taken(takes_triangle, enters_instance);
        let beat = self.searches.as_ref().and_then(|searches| searches.next_beat(has_ready));
        let opcode = beat.map_or(ready.kind.opcode(), Beat::opcode);
        let takes = self.flow.input_ready(opcode);
        let leaves = has_ready & takes & beat.is_none();
        self.flow.cycle((takes & (has_ready | beat.is_some())).then_some(opcode), outcome_leaves);
        if let Some(searches) = &mut self.searches {
            let of_search = [Kind::LastBeat, Kind::Test].map(|kind| outcome_leaves & (outcome.kind == kind));
            searches.cycle(search, has_ready, takes, beat.is_some(), of_search);
        }
        self.jobs.pop_if(outcome_leaves);
        self.queues.push_if(TESTED, outcome.context, outcome_leaves & (outcome.kind == Kind::Node));
        let divides = outcome_leaves & outcome.kind.is_triangle();
        self.operands = select_unpredictable(divides, outcome, self.operands);
        self.has_operands |= divides;
        self.jobs.push_if(ready, leaves);
        if let Some(beat) = beat.filter(|_| takes) {
            let kind = match beat {
                Beat { node: Some(_), .. } => Kind::Test,
                Beat { is_last, .. } if is_last => Kind::LastBeat,
                _ => Kind::Beat,
            };
            self.jobs.push_if(Job { context: 0, kind }, true);
        }
        leaves
    }

    /// The edge of the blocks. A block offers its jobs to the datapath.
    #[inline]
    fn blocks(&mut self, contexts: &impl Contexts, arrived: Option<u8>) {
        let is_free = !self.has_offer & !self.queues.is_ready(FAULT);
        let begins = is_free & self.queues.is_ready(ARRIVALS);
        let context = self.queues.pop_if(ARRIVALS, begins);
        let asked = contexts.asked(context);
        let fails = begins & contexts.failed(context);
        if fails {
            self.queues.put(FAULT, context);
        }
        let has_eight = self.parameters.step.node == NodeKind::Wide8;
        self.offer = select_unpredictable(begins, Job { context, kind: Kind::first(asked, has_eight) }, self.offer);
        let jobs = if asked.count == 0 { 1 + u32::from(has_eight) } else { asked.count.into() };
        let following = jobs - 1;
        self.following = select_unpredictable(begins, following, self.following);
        self.has_offer |= begins & !fails;
        self.queues.push_if(ARRIVALS, arrived.unwrap_or_default(), arrived.is_some());
    }
}
