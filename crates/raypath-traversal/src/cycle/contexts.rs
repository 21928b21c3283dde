//! What the rays in the contexts of a unit do.

use crate::answers::{Answers, Block};
use crate::blocks::BLOCK_BYTES;
use crate::candidate::Verdict;
use crate::engine::{AskedCandidate, Response};
use crate::hardware::UnitParameters;
use crate::model::{Memory, MemoryError, RayRequest, Reply};
use crate::walk::{Asked, Walk};
use raypath_model::{State, StateWords, state};
use raypath_ops::Rules;

/// As many contexts as a number of 8 bits can tell.
pub const CONTEXTS: usize = 256;

/// The rays in the contexts: what they do, whereas [`Timing`](super::timing::Timing) says when. A number of 8 bits
/// selects a context.
pub trait Contexts {
    /// A ray enters a context.
    fn enter(&mut self, context: u8, id: u64, ray: &RayRequest);
    /// Computes the next step of a ray, if `steps`; otherwise nothing changes, and the result is arbitrary. The block
    /// of the ray has arrived if it asked for one.
    fn step(&mut self, context: u8, steps: bool) -> Asked;
    /// What a ray asked for in its last step.
    fn asked(&self, context: u8) -> Asked;
    /// The address of the block that a ray asked for last.
    fn address(&self, context: u8) -> u64;
    /// Whether the memory reported an error for the block that arrived last.
    fn failed(&self, context: u8) -> bool;
    /// The number of a ray that has ended, and its reply.
    fn reply(&self, context: u8) -> (u64, Reply);
}

/// Rays whose blocks arrive at the ports.
#[derive(Debug, Clone)]
pub struct PortContexts {
    parameters: UnitParameters,
    answers: Answers,
    /// A unit uses the first.
    contexts: Box<[Context; CONTEXTS]>,
    beat_bytes: usize,
}

#[derive(Debug, Clone)]
struct Context {
    id: u64,
    walk: Walk,
    block: Block,
    /// Its beats so far, and whether one had an error.
    beats: usize,
    failed: bool,
}

/// The block that has arrived in a context.
struct Arrived<'b> {
    block: &'b Block,
    failed: bool,
}

impl PortContexts {
    /// The contexts of a unit without rays.
    pub fn new(parameters: UnitParameters) -> Self {
        let answers = Answers::new(Rules::Paper, parameters.step);
        let block = [0; BLOCK_BYTES as usize];
        let context = Context { id: 0, walk: Walk::new(&answers), block, beats: 0, failed: false };
        // From a vector, because an array of this size overflows the stack of a small thread.
        let Ok(contexts) = vec![context; CONTEXTS].try_into() else { unreachable!("as many as the array has") };
        Self { parameters, answers, contexts, beat_bytes: parameters.memory_width as usize / 8 }
    }

    /// A beat arrives. Returns its context if it is the last of its block.
    #[inline]
    pub fn arrive(&mut self, response: &Response<'_>) -> Option<u8> {
        let bytes = self.parameters.step.node.block_bytes() as usize;
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

    /// The candidate in a context.
    pub fn candidate(&self, context: u8) -> Option<AskedCandidate> {
        let Context { id, walk, .. } = &self.contexts[usize::from(context)];
        let candidate = walk.candidate(self.parameters.step)?;
        Some(AskedCandidate { tag: context.into(), id: *id, candidate })
    }

    /// A verdict arrives. Returns its context, if it is one.
    pub fn decide(&mut self, tag: u32, verdict: Verdict) -> Option<u8> {
        let context = u8::try_from(tag).ok().filter(|context| u32::from(*context) < self.parameters.contexts)?;
        self.contexts[usize::from(context)].walk.decide(verdict);
        Some(context)
    }

    /// The number of the ray in a context.
    pub fn id(&self, context: u8) -> u64 {
        self.contexts[usize::from(context)].id
    }

    /// No beats have arrived.
    pub fn reset(&mut self) {
        self.contexts.iter_mut().for_each(|context| context.beats = 0);
    }
}

state! { Context { id, walk, block, beats, failed } }

impl State for PortContexts {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        self.contexts[..self.parameters.contexts as usize].pass(words);
    }
}

impl Contexts for PortContexts {
    fn enter(&mut self, context: u8, id: u64, ray: &RayRequest) {
        let context = &mut self.contexts[usize::from(context)];
        // As wide as the ports.
        context.id = id & u64::MAX >> (64 - self.parameters.id_width);
        let ray = RayRequest { base: ray.base & self.parameters.greatest_base(), ..*ray };
        context.walk.begin(&self.answers, self.parameters.step, &ray);
    }

    fn step(&mut self, context: u8, steps: bool) -> Asked {
        if !steps {
            return Asked::NOTHING;
        }
        let Context { walk, block, failed, .. } = &mut self.contexts[usize::from(context)];
        walk.step(&self.answers, self.parameters.step, &Arrived { block, failed: *failed })
    }

    #[inline]
    fn asked(&self, context: u8) -> Asked {
        self.contexts[usize::from(context)].walk.asked()
    }

    #[inline]
    fn address(&self, context: u8) -> u64 {
        let walk = &self.contexts[usize::from(context)].walk;
        walk.address(walk.asked())
    }

    #[inline]
    fn failed(&self, context: u8) -> bool {
        self.contexts[usize::from(context)].failed
    }

    fn reply(&self, context: u8) -> (u64, Reply) {
        let Context { id, walk, .. } = &self.contexts[usize::from(context)];
        (*id, walk.reply(self.parameters.step))
    }
}

impl Memory for Arrived<'_> {
    #[inline]
    fn block(&self, address: u64, bytes: u32) -> Result<&[u8], MemoryError> {
        self.block.get(..bytes as usize).filter(|_| !self.failed).ok_or(MemoryError(address))
    }
}

/// Puts beat `number` into a block. Returns whether it is the last.
#[inline(always)]
fn put<const BYTES: usize>(block: &mut [u8], number: usize, beat: &[u8]) -> Option<bool> {
    let beats = block.as_chunks_mut::<BYTES>().0;
    *beats.get_mut(number)? = *beat.first_chunk()?;
    Some(number + 1 == beats.len())
}
