//! The cycle-exact model of the unit.
//!
//! What a ray does depends on the ray and the scene alone, and when it does it on the handshakes alone. So the model
//! moves the numbers of contexts through queues and pipelines, and computes a step with all its jobs in the cycle in
//! which the hardware finishes it.

mod parts;

use crate::answers::{Answers, Block, ReadyRay};
use crate::blocks::BLOCK_BYTES;
use crate::engine::{BlockRequest, UnitEngine, UnitInputs, UnitOutputs};
use crate::fold::HitLimits;
use crate::hardware::{UnitNetlist, UnitParameters};
use crate::model::{RayRequest, Reply};
use crate::set_up::{Entry, QUOTIENTS};
use crate::state::{Group, RayState, request, status};
use crate::step::{StepParameters, UnitFeatures, finish, prepare};
use parts::{InOrder, Line, Queue, Scheduler, Weights};
use raypath_model::{Flow, Shape};
use raypath_ops::{Binary32, JobKind, Rules, Word};

/// The cycle-exact model of the unit: in every cycle its outputs are those of the hardware.
#[derive(Debug, Clone)]
pub struct UnitModel {
    parameters: UnitParameters,
    answers: Answers,
    contexts: Vec<Context>,
    stacks: Vec<Group<Binary32>>,
    beat_bytes: usize,

    /// The contexts from here on were never used.
    fresh: u32,
    free: Queue<u32>,
    set_up: SetUp,
    starts: Queue<u32>,
    arrivals: Queue<Arrival>,
    issue: Option<Issue>,
    flow: Flow,
    /// The jobs in the datapath, oldest first.
    jobs: InOrder<Job>,
    /// The contexts of outcomes of box jobs that wait for a step, oldest first.
    tested: Queue<u32>,
    /// The triangle whose distance is divided next.
    operands: Option<Job>,
    divider: Line<Job>,
    /// The triangle whose limits are read.
    triangle: Option<Job>,
    /// The context with the closest hit of a block.
    closest: Option<u32>,
    scheduler: Scheduler,
    prepared: Option<Answered>,
    finished: Option<Answered>,
    again: Queue<u32>,
    requests: Queue<BlockRequest>,
    ended: Queue<u32>,
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
    /// Steps.
    pub steps: u64,
    /// Blocks that were requested.
    pub fetches: u64,
    /// Rays that ended.
    pub rays: u64,
}

/// What is kept of a ray.
#[derive(Debug, Clone)]
struct Context {
    id: u64,
    ready: ReadyRay,
    limits: HitLimits<Binary32>,
    state: RayState<Binary32>,
    block: Block,
    /// The triangles of the block that was requested last; 0 for a node.
    count: u32,
    /// The beats of the block so far, and whether one had an error.
    beats: usize,
    failed: bool,
    reply: Reply,
}

/// The rays in the set-up.
#[derive(Debug, Clone)]
struct SetUp {
    /// Cycles until the next ray can enter.
    busy: u32,
    /// Rays that entered, with the cycles in which their constants are known.
    rays: std::collections::VecDeque<(u64, u32)>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Arrival {
    context: u32,
    failed: bool,
}

/// The block whose jobs are offered.
#[derive(Debug, Clone, Copy)]
struct Issue {
    arrival: Arrival,
    place: u32,
}

#[derive(Debug, Clone, Copy, Default)]
struct Job {
    context: u32,
    is_node: bool,
    is_last: bool,
}

/// A step, by the source of its answer.
#[derive(Debug, Clone, Copy)]
struct Answered {
    context: u32,
    source: u32,
}

/// What a ray asks for after a step.
#[derive(Debug, Clone, Copy)]
struct Asked {
    context: u32,
    /// One of [`request`].
    kind: u32,
    address: u32,
}

// The bits of the sources, in the order of `hardware::SOURCES`.
const BOXES: u32 = 1;
const BLOCK: u32 = 2;
const FAULT: u32 = 4;
const START: u32 = 8;
const AGAIN: u32 = 16;

impl UnitModel {
    /// The model of a unit after a reset, whose datapath has this shape.
    pub fn new(shape: &Shape, parameters: UnitParameters) -> Self {
        let contexts = parameters.contexts as usize;
        let features = parameters.step.features;
        Self {
            parameters,
            answers: Answers::new(Rules::Paper, features),
            contexts: vec![Context::new(); contexts],
            stacks: vec![Group::none(Binary32); contexts * parameters.step.stack as usize],
            beat_bytes: parameters.memory_width as usize / 8,
            fresh: 0,
            free: Queue::new(parameters.contexts),
            set_up: SetUp { busy: 0, rays: Default::default() },
            starts: Queue::new(parameters.contexts),
            arrivals: Queue::new(parameters.contexts),
            issue: None,
            flow: Flow::new(shape),
            jobs: InOrder::new(shape.capacity()),
            tested: Queue::new(parameters.contexts),
            operands: None,
            divider: Line::new(parameters.divider_latency),
            triangle: None,
            closest: None,
            scheduler: Scheduler::default(),
            prepared: None,
            finished: None,
            again: Queue::new(parameters.contexts),
            requests: Queue::new(parameters.contexts),
            ended: Queue::new(parameters.contexts),
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
    pub fn idle(&mut self, limit: u64) -> u64 {
        let is_still = self.set_up.busy == 0
            && self.set_up.rays.is_empty()
            && self.jobs.is_empty()
            && self.tested.is_empty()
            && self.operands.is_none()
            && self.divider.is_empty()
            && self.triangle.is_none()
            && self.closest.is_none()
            && self.issue.is_none()
            && self.prepared.is_none()
            && self.finished.is_none()
            && self.arrivals.is_empty()
            && self.starts.is_empty()
            && self.again.is_empty()
            && self.requests.is_settled()
            && self.free.is_settled()
            && self.weights.as_ref().is_none_or(Weights::is_empty)
            && (self.ended.is_empty() || self.hit.is_some() && self.ended.is_settled());
        let cycles = if is_still { limit } else { 0 };
        self.counts.cycles += cycles;
        cycles
    }

    /// The bytes of a beat.
    pub(crate) fn beat_bytes(&self) -> usize {
        self.beat_bytes
    }

    fn has_context(&self) -> bool {
        self.fresh < self.parameters.contexts || self.free.front().is_some()
    }

    /// The step that is finished in this cycle.
    fn step(&mut self, answered: Answered) -> Asked {
        let Self { parameters, answers, contexts, stacks, .. } = self;
        let Answered { context, source } = answered;
        let ray = &mut contexts[context as usize];
        let answer = match source {
            BOXES => answers.node(&ray.ready, ray.state.extent, &ray.block),
            BLOCK => answers.leaf(&ray.ready, ray.limits, &ray.block, ray.count),
            FAULT => Answers::failure(),
            START => Answers::begin(&ray.ready),
            _ => Answers::again(),
        };
        let StepParameters { stack, .. } = parameters.step;
        // The number of entries is a power of two.
        let slot = |level: Word<Binary32, 7>| (context * stack + (level.value & (stack - 1))) as usize;
        let half = prepare(Binary32, ray.state, answer);
        let (state, request) = finish(Binary32, parameters.step, half, stacks[slot(half.deepest)]);
        if request.writes.into() {
            stacks[slot(request.level)] = request.group;
        }
        (ray.state, ray.count) = (state, request.count.value);
        if request.kind.value == request::DONE {
            ray.reply = Reply::of(&state, request.status.value, parameters.step.features);
        }
        Asked { context, kind: request.kind.value, address: request.address.value }
    }

    /// A ray enters a context.
    fn enter(&mut self, id: u64, ray: &RayRequest) -> u32 {
        let is_fresh = self.fresh < self.parameters.contexts;
        let context = if is_fresh { self.fresh } else { self.free.front().unwrap_or(0) };
        self.fresh += u32::from(is_fresh);
        let ready = self.answers.set_up(&Entry::from(ray));
        let kept = &mut self.contexts[context as usize];
        (kept.id, kept.ready, kept.limits) = (id, ready, ray.limits());
        kept.state = RayState::begin(Binary32, Word::truncate(ray.root), ray.t_max.into(), ray.any_hit.into());
        context
    }

    /// A beat arrives. Returns its block if it is the last.
    fn arrive(&mut self, inputs: &UnitInputs<'_>) -> Option<Arrival> {
        let response = inputs.response?;
        let context = self.contexts.get_mut(response.tag as usize)?;
        context.failed |= response.is_error;
        let from = context.beats * self.beat_bytes;
        let part = context.block.get_mut(from..from + self.beat_bytes)?;
        part.copy_from_slice(response.beat.get(..self.beat_bytes)?);
        context.beats += 1;
        if context.beats * self.beat_bytes < BLOCK_BYTES as usize {
            return None;
        }
        context.beats = 0;
        Some(Arrival { context: response.tag, failed: std::mem::take(&mut context.failed) })
    }
}

impl UnitEngine for UnitModel {
    fn outputs(&mut self) -> UnitOutputs {
        UnitOutputs {
            ray_ready: self.set_up.busy <= 1 && self.has_context(),
            hit: self.hit,
            request: self.requests.front(),
            response_ready: true,
        }
    }

    fn cycle(&mut self, inputs: &UnitInputs<'_>) {
        // What the registers say.
        let outcome = if self.flow.output_valid() { self.jobs.front() } else { None };
        let boxes = self.tested.front();
        let fault = self.issue.filter(|issue| issue.arrival.failed).map(|issue| issue.arrival.context);
        let start = self.starts.front();
        let again = self.again.front();
        let bit = |source: u32, context: Option<u32>| if context.is_some() { source } else { 0 };
        let request =
            bit(BOXES, boxes) | bit(BLOCK, self.closest) | bit(FAULT, fault) | bit(START, start) | bit(AGAIN, again);
        let grant = self.scheduler.grant(request);
        let granted = match grant {
            BOXES => boxes,
            BLOCK => self.closest,
            FAULT => fault,
            START => start,
            _ => again,
        };
        let answered = granted.filter(|_| grant != 0).map(|context| Answered { context, source: grant });

        // What moves.
        let folds = self.triangle.filter(|_| self.closest.is_none() || grant == BLOCK);
        let moves = self.triangle.is_none() || folds.is_some();
        let divider_moves = self.divider.front().is_none() || moves;
        let divides = outcome.filter(|job| !job.is_node && (self.operands.is_none() || divider_moves));
        let tested = outcome.filter(|job| job.is_node).map(|job| job.context);
        let outcome_leaves = tested.is_some() || divides.is_some();
        let offer = self.issue.filter(|issue| !issue.arrival.failed).map(|issue| {
            let count = self.contexts[issue.arrival.context as usize].count;
            let (is_node, is_last) = (count == 0, count == 0 || issue.place + 1 == count);
            Job { context: issue.arrival.context, is_node, is_last }
        });
        let kind = |job: Job| if job.is_node { JobKind::Quadbox } else { JobKind::Triangle };
        let leaves = offer.filter(|job| self.flow.input_ready(kind(*job).opcode()));
        let block_ends = leaves.is_some_and(|job| job.is_last) || grant == FAULT;
        let takes_block = self.arrivals.front().is_some() && (self.issue.is_none() || block_ends);
        let can_show = self.hit.is_none() || inputs.hit_ready;
        let entering = inputs.ray.as_ref().filter(|_| self.set_up.busy <= 1 && self.has_context());

        // The edge.
        let asked = self.finished.take().map(|answered| self.step(answered));
        self.finished = self.prepared;
        self.prepared = answered;
        let asks = |kind: u32| asked.filter(|asked| asked.kind == kind);
        let fetched = asks(request::FETCH).map(|asked| BlockRequest { address: asked.address, tag: asked.context });
        self.requests.edge(fetched, inputs.request_ready);
        self.again.edge(asks(request::CONTINUE).map(|asked| asked.context), grant == AGAIN);
        let complete = self.weights.as_ref().map_or(self.ended.front(), Weights::front);
        let released = complete.filter(|_| can_show);
        let takes_ended = match &mut self.weights {
            Some(weights) => weights.edge(self.ended.front(), can_show),
            None => can_show,
        };
        match released {
            Some(context) => {
                let Context { id, reply, .. } = &self.contexts[context as usize];
                self.hit = Some((*id, *reply));
            }
            None if inputs.hit_ready => self.hit = None,
            None => {}
        }
        let ended = asks(request::DONE).map(|asked| asked.context);
        self.ended.edge(ended, takes_ended);

        self.scheduler.edge(grant);
        let uses_free = entering.is_some() && self.fresh == self.parameters.contexts;
        let entered = entering.map(|(id, ray)| self.enter(*id, ray));
        self.free.edge(released, uses_free);
        let begins = self.set_up.edge(self.counts.cycles, entered, self.parameters.divider_latency);
        self.starts.edge(begins, grant == START);

        if moves {
            self.triangle = None;
        }
        if let Some(job) = folds {
            self.closest = job.is_last.then_some(job.context);
        } else if grant == BLOCK {
            self.closest = None;
        }
        if divider_moves {
            if moves {
                self.triangle = self.divider.front();
            }
            self.divider.advance(self.operands.take());
        }

        self.operands = divides.or(self.operands);

        let arrived = self.arrive(inputs);
        let block = if takes_block { self.arrivals.front() } else { None };
        self.arrivals.edge(arrived, takes_block);
        self.issue = match (block, self.issue) {
            (Some(arrival), _) => Some(Issue { arrival, place: 0 }),
            (None, _) if block_ends => None,
            (None, Some(issue)) if leaves.is_some() => Some(Issue { place: issue.place + 1, ..issue }),
            (None, issue) => issue,
        };
        self.tested.edge(tested, grant == BOXES);
        self.flow.cycle(leaves.map(|job| kind(job).opcode()), outcome_leaves);
        self.jobs.edge(leaves, outcome_leaves);

        self.counts.cycles += 1;
        self.counts.steps += u64::from(asked.is_some());
        self.counts.fetches += u64::from(fetched.is_some());
        self.counts.rays += u64::from(ended.is_some());
        self.counts.boxes += u64::from(leaves.is_some_and(|job| job.is_node));
        self.counts.triangles += u64::from(leaves.is_some_and(|job| !job.is_node));
    }

    fn reset(&mut self) {
        self.fresh = 0;
        self.set_up = SetUp { busy: 0, rays: Default::default() };
        let queues = [&mut self.free, &mut self.starts, &mut self.tested, &mut self.again, &mut self.ended];
        queues.into_iter().for_each(Queue::clear);
        self.arrivals.clear();
        self.requests.clear();
        (self.issue, self.operands, self.triangle, self.closest, self.hit) = (None, None, None, None, None);
        (self.prepared, self.finished) = (None, None);
        self.flow.reset();
        self.jobs.clear();
        self.divider.clear();
        self.weights.iter_mut().for_each(Weights::clear);
        self.scheduler = Scheduler::default();
        self.contexts.iter_mut().for_each(|context| (context.beats, context.failed) = (0, false));
        self.counts = UnitCounts::default();
    }
}

impl SetUp {
    /// The clock edge of cycle `now`: a ray enters. Returns the context whose constants are known.
    #[inline]
    fn edge(&mut self, now: u64, entered: Option<u32>, divider_latency: u32) -> Option<u32> {
        self.busy = self.busy.saturating_sub(1);
        let begins = self.rays.front().filter(|(due, _)| *due == now).map(|(_, context)| *context);
        if begins.is_some() {
            self.rays.pop_front();
        }
        if let Some(context) = entered {
            // The operands of the last quotient enter a register, then the divider.
            self.rays.push_back((now + QUOTIENTS as u64 + 1 + u64::from(divider_latency), context));
            self.busy = QUOTIENTS as u32;
        }
        begins
    }
}

impl Context {
    fn new() -> Self {
        let zero = [0.0; 3];
        let ray = RayRequest {
            origin: zero,
            direction: zero,
            t_min: 0.0,
            t_max: 0.0,
            any_hit: false,
            cull_back: false,
            cull_front: false,
            root: 0,
        };
        Self {
            id: 0,
            ready: Answers::new(Rules::Paper, UnitFeatures::OFF).set_up(&Entry::from(&ray)),
            limits: ray.limits(),
            state: RayState::begin(Binary32, Word::truncate(0), 0.0.into(), false.into()),
            block: [0; BLOCK_BYTES as usize],
            count: 0,
            beats: 0,
            failed: false,
            reply: Reply { status: status::MISS, hit: None, nodes: 0, triangles: 0 },
        }
    }
}
