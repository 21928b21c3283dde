//! The cycle-exact model of the unit.
//!
//! What a ray does depends on the ray and the scene alone, and when it does it on the handshakes alone. So [`Timing`]
//! moves the numbers of contexts through queues and pipelines, and [`Contexts`] compute what their rays do.

pub(crate) mod ahead;
pub(crate) mod contexts;
mod parts;
mod searches;
pub(crate) mod timing;

use crate::engine::{UnitEngine, UnitInputs, UnitOutputs};
use crate::hardware::{UnitNetlist, UnitParameters};
use crate::walk::{Asked, AskedKind};
use contexts::{Contexts, PortContexts};
use raypath_model::{Shape, state};
use searches::Searches;
pub use timing::UnitCounts;
use timing::{Edge, Timing};

/// The cycle-exact model of the unit: in every cycle its outputs are those of the hardware.
#[derive(Debug, Clone)]
pub struct UnitModel {
    timing: Timing,
    contexts: PortContexts,
}

state! { UnitModel { timing, contexts } }

/// A ray in a context of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RayInside {
    /// The number of the context, which is the tag of its requests.
    pub context: u32,
    /// The number of the ray.
    pub id: u64,
    /// What it waits for.
    pub phase: RayPhase,
    /// The address of the block that it asked for last; before, the first of its window.
    pub address: u64,
}

/// What a ray in a context waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RayPhase {
    /// The constants of the ray.
    SetUp,
    /// A block of the memory.
    Memory,
    /// The jobs of a block, or the next step.
    Jobs,
    /// The verdict on a candidate.
    Verdict,
    /// The channel of hits: the ray has ended.
    Ended,
}

impl UnitModel {
    /// The model of a unit after a reset, whose datapath has this shape.
    pub fn new(shape: &Shape, parameters: UnitParameters) -> Self {
        Self { timing: Timing::new(shape, parameters), contexts: PortContexts::new(parameters) }
    }

    /// The model of a netlist.
    pub fn of(unit: &UnitNetlist) -> Self {
        Self::new(&unit.shape(), unit.parameters)
    }

    /// What the unit did since its last reset.
    pub fn counts(&self) -> UnitCounts {
        self.timing.counts()
    }

    /// The rays in contexts, by context. A ray whose hit is at the outputs has left its context.
    pub fn rays(&self) -> impl Iterator<Item = RayInside> + '_ {
        let is_requesting = self.timing.requesting();
        self.timing.occupied().map(move |context| {
            let Asked { kind, .. } = self.contexts.asked(context);
            let phase = match kind {
                AskedKind::Begin => RayPhase::SetUp,
                AskedKind::Block if is_requesting[usize::from(context)] => RayPhase::Memory,
                AskedKind::Block | AskedKind::Again => RayPhase::Jobs,
                AskedKind::Verdict => RayPhase::Verdict,
                AskedKind::Nothing => RayPhase::Ended,
            };
            let address = self.contexts.address(context);
            RayInside { context: context.into(), id: self.contexts.id(context), phase, address }
        })
    }

    /// Advances up to `limit` cycles in which no ray is offered, no response arrives, and nothing is taken, if that
    /// changes nothing but time. Returns the number of cycles, 0 if something moves.
    pub fn idle(&mut self, limit: u64) -> u64 {
        let cycles = if self.timing.is_still() { limit } else { 0 };
        self.timing.skip(cycles);
        cycles
    }
}

impl UnitEngine for UnitModel {
    #[inline]
    fn outputs(&mut self) -> UnitOutputs {
        let Self { timing, contexts } = self;
        let (request, candidate) = (timing.request(contexts), timing.candidate());
        let candidate = candidate.and_then(|tag| contexts.candidate(tag));
        let search = timing.searches.as_ref().map(Searches::outputs);
        let (is_idle, ray_ready, hit) = (timing.is_idle(), timing.ray_ready(), timing.hit());
        UnitOutputs { is_idle, ray_ready, hit, candidate, request, response_ready: true, search }
    }

    fn cycle(&mut self, inputs: &UnitInputs<'_>) {
        // The steps of this cycle read the blocks before a beat of this cycle is written.
        let Self { timing, contexts } = self;
        let UnitInputs { flush, ray, hit_ready, candidate_ready, verdict, request_ready, response, search } = inputs;
        let arrived = response.as_ref().and_then(|response| contexts.arrive(response));
        let (hit_ready, request_ready) = (*hit_ready, *request_ready);
        let ray = ray.as_ref().filter(|_| timing.ray_ready());
        let decided = verdict.and_then(|(tag, verdict)| contexts.decide(tag, verdict));
        let candidate_ready = *candidate_ready;
        let flush = *flush;
        timing
            .cycle(contexts, &Edge { flush, ray, hit_ready, candidate_ready, decided, request_ready, arrived, search });
    }

    fn reset(&mut self) {
        self.timing.reset();
        self.contexts.reset();
    }

    fn counts(&self) -> Option<UnitCounts> {
        Some(self.timing.counts())
    }
}
