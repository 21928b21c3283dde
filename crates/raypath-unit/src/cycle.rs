//! The cycle-exact model of the unit.
//!
//! What a ray does depends on the ray and the scene alone, and when it does it on the handshakes alone. So the model
//! moves the numbers of contexts through queues and pipelines, and computes a step with all its jobs in the cycle in
//! which the hardware finishes it.

mod context;
mod parts;

use crate::answers::Answers;
use crate::blocks::NodeKind;
use crate::engine::{BlockRequest, Response, UnitEngine, UnitInputs, UnitOutputs};
use crate::hardware::{DECODER_LATENCY, UnitNetlist, UnitParameters};
use crate::model::{RayRequest, Reply};
use crate::native;
use crate::set_up::{Entry, QUOTIENTS};
use crate::state::{Answer, RayState, request};
use crate::step::StepParameters;
use context::{Context, Job, Kind};
use parts::{Line, Queues, Ring, Scheduler, Weights};
use raypath_model::{Flow, Shape};
use raypath_ops::{Binary32, Rules, Word};
use std::mem::replace;

/// The cycle-exact model of the unit: in every cycle its outputs are those of the hardware.
#[derive(Debug, Clone)]
pub struct UnitModel {
    parameters: UnitParameters,
    answers: Answers,
    /// A unit uses the first.
    contexts: Box<[Context; CONTEXTS]>,
    beat_bytes: usize,

    /// The contexts from here on were never used.
    fresh: u32,
    queues: Queues<7>,
    /// Cycles until the next ray can enter the set-up.
    busy: u32,
    /// A ray entered an instance in the last turn of the set-up, so that a new ray has the next one.
    yields: bool,
    /// The rays whose quotients are divided.
    set_up: Line<u8>,
    /// The context whose block failed.
    fault: Option<u8>,
    /// The job that is offered to the datapath, and how many jobs of its block follow it.
    offer: Option<Job>,
    following: u32,
    /// With quantised nodes: the jobs of blocks whose boxes are decoded.
    decoder: Option<Line<Job>>,
    flow: Flow,
    /// The jobs in the datapath.
    jobs: Ring<Job>,
    /// The triangle whose distance is divided next.
    operands: Option<Job>,
    divider: Line<Job>,
    /// The triangle whose limits are read.
    triangle: Option<Job>,
    /// The context with the closest hit of a block.
    closest: Option<u8>,
    scheduler: Scheduler,
    prepared: Answered,
    finished: Answered,
    /// With barycentric coordinates, which are divided before a hit is shown.
    weights: Option<Weights>,
    hit: Option<(u64, Reply)>,
    counts: UnitCounts,
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
}

/// A step of a context, by the source of its answer; none if the source is 0.
#[derive(Debug, Clone, Copy, Default)]
struct Answered {
    context: u8,
    source: u32,
}

// The bits of the sources, in the order of `hardware::SOURCES`.
const BOXES: u32 = 1;
const BLOCK: u32 = 2;
const FAULT: u32 = 4;
const START: u32 = 8;
const AGAIN: u32 = 16;

// The numbers of the queues. Those of answers have the number of their source's bit.
const TESTED: usize = BOXES.ilog2() as usize;
const STARTS: usize = START.ilog2() as usize;
const AGAINS: usize = AGAIN.ilog2() as usize;
const FREE: usize = 1;
const ARRIVALS: usize = 2;
const REQUESTS: usize = 5;
const ENDED: usize = 6;

/// As many contexts as a number of 8 bits can tell.
const CONTEXTS: usize = 256;

impl UnitModel {
    /// The model of a unit after a reset, whose datapath has this shape.
    pub fn new(shape: &Shape, parameters: UnitParameters) -> Self {
        // From a vector, because an array of this size overflows the stack of a small thread.
        let Ok(contexts) = vec![Context::new(); CONTEXTS].try_into() else { unreachable!("as many as the array has") };
        let StepParameters { node: nodes, features, .. } = parameters.step;
        Self {
            parameters,
            answers: Answers::new(Rules::Paper, parameters.step),
            contexts,
            beat_bytes: parameters.memory_width as usize / 8,
            fresh: 0,
            queues: Queues::new(),
            busy: 0,
            yields: false,
            // The operands of the last quotient enter a register, then the divider.
            set_up: Line::new(QUOTIENTS as u32 + 1 + parameters.divider_latency),
            fault: None,
            offer: None,
            following: 0,
            decoder: (nodes == NodeKind::Quantised).then(|| Line::new(DECODER_LATENCY)),
            flow: Flow::new(shape),
            jobs: Ring::new(),
            operands: None,
            divider: Line::new(parameters.divider_latency),
            triangle: None,
            closest: None,
            scheduler: Scheduler::default(),
            prepared: Answered::default(),
            finished: Answered::default(),
            weights: features.barycentrics.then(|| Weights::new(parameters.divider_latency)),
            hit: None,
            counts: UnitCounts::default(),
        }
    }

    /// The model of a netlist.
    pub fn of(unit: &UnitNetlist) -> Self {
        Self::new(&unit.shape(), unit.parameters)
    }

    /// What the unit did since its last reset.
    pub fn counts(&self) -> UnitCounts {
        self.counts
    }

    /// Advances up to `limit` cycles in which no ray is offered, no response arrives, and nothing is taken, if that
    /// changes nothing but time. Returns the number of cycles, 0 if something moves.
    // Within `simulate`, its many conditions would be computed in every cycle.
    #[inline(never)]
    pub fn idle(&mut self, limit: u64) -> u64 {
        let waiting = 1 << TESTED | 1 << STARTS | 1 << AGAINS | 1 << ARRIVALS | 1 << ENDED;
        let is_still = self.busy == 0
            && self.set_up.is_empty()
            && self.jobs.is_empty()
            && self.operands.is_none()
            && self.divider.is_empty()
            && self.triangle.is_none()
            && self.closest.is_none()
            && self.fault.is_none()
            && self.offer.is_none()
            && self.decoder.as_ref().is_none_or(Line::is_empty)
            && self.prepared.source == 0
            && self.finished.source == 0
            && self.queues.are_settled()
            && self.weights.as_ref().is_none_or(Weights::is_empty)
            && self.queues.ready() & waiting == 0;
        let cycles = if is_still { limit } else { 0 };
        self.counts.cycles += cycles;
        cycles
    }

    /// The bytes of a beat.
    pub(crate) fn beat_bytes(&self) -> usize {
        self.beat_bytes
    }

    /// The bytes of a block.
    pub(crate) fn block_bytes(&self) -> u32 {
        self.parameters.step.node.block_bytes()
    }

    #[inline]
    fn has_context(&self) -> bool {
        (self.fresh < self.parameters.contexts) | (self.queues.ready() >> FREE & 1 == 1)
    }

    #[inline]
    fn ray_ready(&self) -> bool {
        (self.busy <= 1) & self.has_context() && self.transformed().is_none()
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

    /// The step that is finished in this cycle. Returns what the ray asks for: one of [`request`].
    fn step(&mut self, Answered { context, source }: Answered) -> u32 {
        // Each kind of answer has a copy of the step, from which the compiler removes what other answers need.
        match source {
            BOXES => self.advance(context, |answers, ray| answers.node(ray.space(), ray.state.extent, &ray.block)),
            BLOCK => self.advance(context, |answers, ray| answers.leaf(ray.space(), ray.limits, &ray.block, ray.count)),
            FAULT => self.advance(context, |_, _| Answers::failure()),
            START if self.contexts[usize::from(context)].is_instance => {
                self.advance(context, |_, ray| Answers::enter(&ray.inside, &ray.block))
            }
            START => self.advance(context, |_, ray| Answers::begin(&ray.ready)),
            _ => self.advance(context, |_, _| Answers::again()),
        }
    }

    #[inline(always)]
    fn advance(&mut self, context: u8, answer: impl FnOnce(&Answers, &Context) -> Answer<Binary32>) -> u32 {
        let (parameters, ray) = (self.parameters.step, &mut self.contexts[usize::from(context)]);
        let answer = answer(&Answers::new(Rules::Paper, parameters), ray);
        let request = native::step(parameters, &mut ray.state, answer, &mut ray.stack);
        (ray.address, ray.count, ray.status) = (request.address.value, request.count.value, request.status.value);
        ray.is_instance = request.is_instance.into();
        request.kind.value
    }

    /// A ray enters a context.
    fn enter(&mut self, id: u64, ray: &RayRequest) -> u8 {
        let context = if self.fresh < self.parameters.contexts {
            self.fresh += 1;
            (self.fresh - 1) as u8
        } else {
            self.queues.pop(FREE)
        };
        let ready = self.answers.set_up(&Entry::from(ray));
        let kept = &mut self.contexts[usize::from(context)];
        (kept.id, kept.ready, kept.limits, kept.is_instance) = (id, ready, ray.limits(), false);
        kept.state = RayState::begin(Binary32, Word::truncate(ray.root), ray.t_max.into(), ray.any_hit.into());
        context
    }

    /// A beat arrives. Returns the context of its block if it is the last.
    #[inline]
    fn arrive(&mut self, response: &Response<'_>) -> Option<u8> {
        let bytes = self.block_bytes() as usize;
        let tag = u8::try_from(response.tag).ok().filter(|tag| u32::from(*tag) < self.parameters.contexts)?;
        let context = &mut self.contexts[usize::from(tag)];
        let (block, beats) = (context.block.get_mut(..bytes)?, &context.beats);
        let is_last = match self.beat_bytes {
            16 => put::<16>(block, *beats, response.beat)?,
            32 => put::<32>(block, *beats, response.beat)?,
            64 => put::<64>(block, *beats, response.beat)?,
            _ => put::<128>(block, *beats, response.beat)?,
        };
        context.failed = response.is_error | (context.failed & (context.beats > 0));
        context.beats = if is_last { 0 } else { context.beats + 1 };
        is_last.then_some(tag)
    }

    /// Chooses the answer of the next step, and takes it.
    #[inline]
    fn choose(&mut self) -> Answered {
        let bit = |source: u32, has_answer: bool| if has_answer { source } else { 0 };
        let queued = self.queues.ready() & (BOXES | START | AGAIN);
        let request = queued | bit(BLOCK, self.closest.is_some()) | bit(FAULT, self.fault.is_some());
        if request == 0 {
            return Answered::default();
        }
        let source = self.scheduler.grant(request);
        let context = match source {
            BLOCK => self.closest.take().unwrap_or_default(),
            FAULT => self.fault.take().unwrap_or_default(),
            queued => self.queues.pop(queued.ilog2() as usize),
        };
        Answered { context, source }
    }

    /// The edge of the requests and the steps.
    #[inline]
    fn walk(&mut self, chosen: Answered, request_ready: bool) {
        if request_ready && self.queues.front(REQUESTS).is_some() {
            self.queues.pop(REQUESTS);
        }
        let finished = replace(&mut self.finished, replace(&mut self.prepared, chosen));
        if finished.source != 0 {
            self.counts.steps += 1;
            let queue = match self.step(finished) {
                request::FETCH => REQUESTS,
                request::CONTINUE => AGAINS,
                _ => ENDED,
            };
            self.counts.fetches += u64::from(queue == REQUESTS);
            self.counts.rays += u64::from(queue == ENDED);
            self.queues.push(queue, finished.context);
        }
    }

    /// The edge of the hits.
    #[inline]
    fn hits(&mut self, ready: bool) {
        let can_show = ready || self.hit.is_none();
        let ended = self.queues.front(ENDED);
        let shown = self.weights.as_ref().map_or(ended, Weights::front).filter(|_| can_show);
        if self.weights.as_mut().map_or(shown.is_some(), |weights| weights.edge(ended, can_show)) {
            self.queues.pop(ENDED);
        }
        if can_show {
            self.hit = shown.map(|context| {
                let Context { id, state, status, .. } = &self.contexts[usize::from(context)];
                (*id, Reply::of(state, *status, self.parameters.step.features))
            });
        }
        if let Some(context) = shown {
            self.queues.push(FREE, context);
        }
    }

    /// The edge of the rays that begin, and of those that enter an instance. Returns whether one does.
    #[inline]
    fn rays(&mut self, ray: Option<&(u64, RayRequest)>) -> bool {
        let in_instance = self.transformed();
        let is_ready = self.busy <= 1;
        let entered = if in_instance.is_none() {
            ray.filter(|_| self.ray_ready()).map(|(id, ray)| self.enter(*id, ray))
        } else {
            in_instance.filter(|_| is_ready)
        };
        if is_ready {
            self.yields = in_instance.is_some();
            if let Some(context) = in_instance {
                let Context { ready, inside, block, .. } = &mut self.contexts[usize::from(context)];
                *inside = self.answers.instance(ready, block);
            }
        }
        self.busy = if entered.is_some() { QUOTIENTS as u32 } else { self.busy.saturating_sub(1) };
        if let Some(context) = self.set_up.advance(entered) {
            self.queues.push(STARTS, context);
        }
        is_ready && in_instance.is_some()
    }

    /// The edge of the distances of triangles. Returns whether an outcome can be taken.
    #[inline]
    fn distances(&mut self) -> bool {
        // One branch: each condition alone is as random as the traffic.
        if self.operands.is_none() & self.triangle.is_none() & self.divider.is_empty() {
            return true;
        }
        if self.closest.is_none()
            && let Some(Job { context, kind }) = self.triangle.take()
        {
            self.closest = (kind == Kind::LastTriangle).then_some(context);
        }
        if self.triangle.is_none() || self.divider.front().is_none() {
            let divided = self.divider.advance(self.operands.take());
            self.triangle = self.triangle.or(divided);
        }
        self.operands.is_none()
    }

    /// The edge of the datapath.
    #[inline]
    fn jobs(&mut self, enters_instance: bool) {
        let takes_triangle = self.distances();
        let outcome_leaves = self.flow.output_valid()
            && match self.jobs.first().kind {
                Kind::Node | Kind::Origin => true,
                Kind::Triangle | Kind::LastTriangle => takes_triangle,
                Kind::Direction => enters_instance,
            };
        let ready = self.decoder.as_ref().map_or(self.offer, Line::front);
        let leaves = ready.filter(|job| self.flow.input_ready(job.kind.opcode()));
        self.flow.cycle(leaves.map(|job| job.kind.opcode()), outcome_leaves);
        if outcome_leaves {
            let job = self.jobs.pop();
            match job.kind {
                Kind::Node => self.queues.push(TESTED, job.context),
                Kind::Triangle | Kind::LastTriangle => self.operands = Some(job),
                Kind::Origin | Kind::Direction => {}
            }
        }
        if let Some(job) = leaves {
            self.jobs.push(job);
            let counter = match job.kind {
                Kind::Node => &mut self.counts.boxes,
                Kind::Triangle | Kind::LastTriangle => &mut self.counts.triangles,
                Kind::Origin | Kind::Direction => &mut self.counts.transforms,
            };
            *counter += 1;
        }
        let issued = match &mut self.decoder {
            None => leaves,
            Some(decoder) if ready.is_none() || leaves.is_some() => {
                decoder.advance(self.offer);
                self.offer
            }
            Some(_) => None,
        };
        if let Some(job) = issued {
            let kind = match job.kind {
                Kind::Origin => Kind::Direction,
                _ if self.following == 1 => Kind::LastTriangle,
                _ => Kind::Triangle,
            };
            self.offer = (self.following > 0).then_some(Job { kind, ..job });
            self.following = self.following.saturating_sub(1);
        }
    }

    /// The edge of the blocks.
    #[inline]
    fn blocks(&mut self, response: Option<&Response<'_>>) {
        if self.offer.is_none() & self.fault.is_none() & (self.queues.ready() >> ARRIVALS & 1 == 1) {
            let context = self.queues.pop(ARRIVALS);
            self.issue(context);
        }
        if let Some(context) = response.and_then(|response| self.arrive(response)) {
            self.queues.push(ARRIVALS, context);
        }
    }

    /// Offers the jobs of a block.
    #[inline]
    fn issue(&mut self, context: u8) {
        let Context { count, is_instance, failed, .. } = self.contexts[usize::from(context)];
        let kind = match count {
            0 => Kind::Node,
            1 => Kind::LastTriangle,
            _ if is_instance => Kind::Origin,
            _ => Kind::Triangle,
        };
        self.fault = failed.then_some(context);
        self.offer = (!failed).then_some(Job { context, kind });
        self.following = count.saturating_sub(1);
    }
}

impl UnitEngine for UnitModel {
    #[inline]
    fn outputs(&mut self) -> UnitOutputs {
        let address = |context: u8| self.contexts[usize::from(context)].address;
        UnitOutputs {
            ray_ready: self.ray_ready(),
            hit: self.hit,
            request: self.queues.front(REQUESTS).map(|tag| BlockRequest { address: address(tag), tag: tag.into() }),
            response_ready: true,
        }
    }

    #[inline]
    fn cycle(&mut self, inputs: &UnitInputs<'_>) {
        // Each part reads what the parts after it had in registers, because it comes after them.
        let chosen = self.choose();
        let enters_instance = self.rays(inputs.ray.as_ref());
        self.hits(inputs.hit_ready);
        self.walk(chosen, inputs.request_ready);
        self.jobs(enters_instance);
        self.blocks(inputs.response.as_ref());
        self.queues.edge();
        self.counts.cycles += 1;
    }

    fn reset(&mut self) {
        self.fresh = 0;
        (self.busy, self.yields) = (0, false);
        self.set_up.clear();
        self.queues.clear();
        (self.fault, self.offer, self.operands) = (None, None, None);
        (self.triangle, self.closest, self.hit) = (None, None, None);
        (self.prepared, self.finished) = (Answered::default(), Answered::default());
        self.flow.reset();
        self.jobs.clear();
        self.divider.clear();
        self.weights.iter_mut().for_each(Weights::clear);
        self.decoder.iter_mut().for_each(Line::clear);
        self.scheduler = Scheduler::default();
        self.contexts.iter_mut().for_each(|context| context.beats = 0);
        self.counts = UnitCounts::default();
    }
}

/// Puts beat `number` into a block. Returns whether it is the last.
#[inline(always)]
fn put<const BYTES: usize>(block: &mut [u8], number: usize, beat: &[u8]) -> Option<bool> {
    let beats = block.as_chunks_mut::<BYTES>().0;
    *beats.get_mut(number)? = *beat.first_chunk()?;
    Some(number + 1 == beats.len())
}
