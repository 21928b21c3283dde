//! The cycle-exact model of the unit.

use super::layout::{UnitHit, UnitRay};
use super::query::{UnitCandidate, UnitVerdict};
use super::{Unit, check_address};
use crate::Error;
use crate::state::{restore, save};
use raypath_model::state;
use raypath_traversal::search::SEARCH_BLOCK;
use raypath_traversal::{
    self as unit, BlockRequest, RayInside, RayPhase, Response, SearchInputs, SearchOutputs, UnitCounts, UnitEngine,
    UnitParameters,
};
use std::sync::Arc;

/// The cycle-exact model of a unit. In every cycle its outputs are those of the hardware.
///
/// A cycle consists of [`outputs`](Self::outputs), which depend on earlier cycles alone, then a [`step`](Self::step).
#[derive(Debug, Clone)]
pub struct UnitModel {
    inner: unit::UnitModel,
    outputs: unit::UnitOutputs,
    parameters: UnitParameters,
    /// For each tag, the beats of the requested block that have not arrived.
    awaited: Vec<u32>,
    /// The same for the tags of searches.
    awaited_vectors: Vec<u32>,
    /// For each tag, whether its candidate was taken and has no verdict.
    undecided: Vec<bool>,
    stalls: UnitStalls,
    /// The unit in words.
    unit: Arc<str>,
}

/// Where rays, hits and requests waited since the last reset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct UnitStalls {
    /// The rays inside, accepted and not taken as hits.
    pub rays_inside: u64,
    /// The sum of the rays inside over all cycles: divided by the cycles, the contexts in use.
    pub ray_cycles: u64,
    /// Cycles in which a ray was offered and not accepted.
    pub ray_stalls: u64,
    /// Cycles in which a hit was not taken.
    pub hit_stalls: u64,
    /// Cycles in which a request was not taken.
    pub request_stalls: u64,
}

state! { UnitStalls { rays_inside, ray_cycles, ray_stalls, hit_stalls, request_stalls } }

state! { UnitModel { inner, awaited, awaited_vectors, undecided, stalls } }

/// The inputs of the unit in a cycle.
#[derive(Debug, Clone, Copy, Default)]
pub struct UnitInputs<'i> {
    /// Drops all rays, from the next cycle until the unit is idle.
    pub flush: bool,
    /// A ray that is offered, with its number. It is accepted if the outputs say so.
    pub ray: Option<(u64, &'i UnitRay)>,
    /// Whether the hit at the outputs is taken.
    pub hit_ready: bool,
    /// Whether the candidate at the outputs is taken.
    pub candidate_ready: bool,
    /// A verdict on a candidate that was taken, with its tag.
    pub verdict: Option<(u32, UnitVerdict)>,
    /// Whether the request at the outputs is taken.
    pub request_ready: bool,
    /// A beat of a requested block.
    pub response: Option<Response<'i>>,
    /// The inputs of searches, in a unit that has them.
    pub search: SearchInputs<'i>,
}

/// The outputs of the unit in a cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnitOutputs {
    /// No ray is in the unit.
    pub is_idle: bool,
    /// Whether a ray is accepted.
    pub ray_ready: bool,
    /// The number of a ray that has ended, and its hit.
    pub hit: Option<(u64, UnitHit)>,
    /// A candidate: the tag of its verdict, the number of its ray, and what it is.
    pub candidate: Option<(u32, u64, UnitCandidate)>,
    /// A request of a block.
    pub request: Option<BlockRequest>,
    /// The outputs of searches, in a unit that has them.
    pub search: Option<SearchOutputs>,
}

impl UnitModel {
    /// A unit after a reset.
    pub fn new(unit: &Unit) -> Self {
        let mut inner = unit::UnitModel::of(unit.netlist());
        let parameters = unit.parameters();
        let (outputs, awaited) = (inner.outputs(), vec![0; parameters.contexts as usize]);
        let undecided = vec![false; parameters.contexts as usize];
        let awaited_vectors = vec![0; parameters.search.0.map_or(0, |search| search.blocks as usize)];
        Self {
            inner,
            outputs,
            parameters,
            awaited,
            awaited_vectors,
            undecided,
            stalls: UnitStalls::default(),
            unit: unit.description().into(),
        }
    }

    /// The outputs in this cycle.
    pub fn outputs(&self) -> UnitOutputs {
        let unit::UnitOutputs { is_idle, ray_ready, hit, candidate, request, search, .. } = self.outputs;
        let candidate = candidate.map(|asked| (asked.tag, asked.id, (&asked.candidate).into()));
        let hit = hit.map(|(id, reply)| (id, (&reply).into()));
        UnitOutputs { is_idle, ray_ready, hit, candidate, request, search }
    }

    /// The clock edge that ends this cycle.
    ///
    /// # Errors
    /// A number of a ray or of a job with more bits than the unit has for it; a ray or a job with a value that its port
    /// does not have; a job for a unit without searches; a beat for a tag without an outstanding request, or of another
    /// size than the memory's width; a verdict for a tag whose candidate was not taken. Then no cycle passes.
    pub fn step(&mut self, inputs: &UnitInputs<'_>) -> Result<(), Error> {
        if let Some((id, ray)) = inputs.ray {
            self.check_ray(id, ray)?;
        }
        if let Some(response) = &inputs.response {
            self.check_response(&self.awaited, response)?;
        }
        if let Some(response) = &inputs.search.response {
            self.check_response(&self.awaited_vectors, response)?;
        }
        if let Some((id, base, address)) = inputs.search.job {
            self.check_job(id, base, address)?;
        }
        if let Some((tag, _)) = inputs.verdict
            && !self.undecided.get(tag as usize).is_some_and(|is_undecided| *is_undecided)
        {
            let problem = format!("a verdict with the tag {tag}, expected that of a candidate that was taken");
            return Err(Error::Argument(problem));
        }
        let UnitInputs { flush, ray, hit_ready, candidate_ready, verdict, request_ready, response, search } = *inputs;
        if let Some(tag) = verdict.map(|(tag, _)| tag as usize) {
            self.undecided[tag] = false;
        }
        if let Some(asked) = self.outputs.candidate.filter(|_| candidate_ready) {
            self.undecided[asked.tag as usize] = true;
        }
        let verdict = verdict.map(|(tag, verdict)| (tag, verdict.into()));
        let ray = ray.map(|(id, ray)| (id, ray.into()));
        self.count(ray.is_some(), hit_ready, request_ready, 1);
        self.inner.cycle(&unit::UnitInputs {
            flush,
            ray,
            hit_ready,
            candidate_ready,
            verdict,
            request_ready,
            response,
            search,
        });
        let UnitParameters { memory_width, step, .. } = self.parameters;
        let request = self.outputs.request.filter(|_| request_ready);
        await_beats(&mut self.awaited, response, request, 8 * step.node.block_bytes() / memory_width);
        let request = self.outputs.search.and_then(|search| search.request).filter(|_| search.request_ready);
        await_beats(&mut self.awaited_vectors, search.response, request, 8 * SEARCH_BLOCK / memory_width);
        self.outputs = self.inner.outputs();
        if self.outputs.is_idle {
            // Rays that were flushed have no hits.
            self.stalls.rays_inside = 0;
        }
        Ok(())
    }

    /// Advances up to `limit` cycles in which no ray is offered, no beat arrives and nothing is taken, and stops in the
    /// first in which an input could change something: with a hit, a candidate or a request, or in which a ray is accepted and was
    /// not before. Returns the number of cycles.
    pub fn skip(&mut self, limit: u64) -> u64 {
        let (mut passed, mut was_ready) = (0, self.outputs.ray_ready);
        while passed < limit && self.waits_for_nothing() {
            if self.outputs.ray_ready && !was_ready {
                break;
            }
            was_ready = self.outputs.ray_ready;
            let still = self.inner.idle(limit - passed);
            self.count(false, false, false, still.max(1));
            if still == 0 {
                self.inner.cycle(&unit::UnitInputs::default());
                self.outputs = self.inner.outputs();
            }
            passed += still.max(1);
        }
        passed
    }

    /// Nothing is at the outputs that could be taken.
    fn waits_for_nothing(&self) -> bool {
        let unit::UnitOutputs { hit, candidate, request, search, .. } = &self.outputs;
        let of_searches = search.is_some_and(|search| search.result.is_some() || search.request.is_some());
        hit.is_none() && candidate.is_none() && request.is_none() && !of_searches
    }

    /// What the unit did since its last reset.
    pub fn counts(&self) -> UnitCounts {
        self.inner.counts()
    }

    /// Where rays, hits and requests waited since the last reset.
    pub fn stalls(&self) -> UnitStalls {
        self.stalls
    }

    /// The rays in contexts and what they wait for, by context: from cycle to cycle, the timeline of the unit.
    pub fn rays(&self) -> impl Iterator<Item = RayInside> + '_ {
        self.inner.rays().map(|ray| {
            let is_awaited = self.awaited.get(ray.context as usize).is_some_and(|&beats| beats > 0);
            if is_awaited { RayInside { phase: RayPhase::Memory, ..ray } } else { ray }
        })
    }

    /// Counts cycles with these inputs.
    fn count(&mut self, offers: bool, hit_ready: bool, request_ready: bool, cycles: u64) {
        let unit::UnitOutputs { ray_ready, hit, request, .. } = self.outputs;
        let stalls = &mut self.stalls;
        stalls.ray_cycles = stalls.ray_cycles.saturating_add(stalls.rays_inside.saturating_mul(cycles));
        stalls.ray_stalls += u64::from(offers & !ray_ready);
        stalls.hit_stalls += u64::from(hit.is_some() & !hit_ready);
        stalls.request_stalls += u64::from(request.is_some() & !request_ready);
        stalls.rays_inside += u64::from(offers & ray_ready);
        stalls.rays_inside = stalls.rays_inside.saturating_sub((hit.is_some() & hit_ready).into());
    }

    /// The whole state as bytes, for [`restore`](Self::restore).
    pub fn save(&self) -> Vec<u8> {
        save(self, &self.unit)
    }

    /// Takes over a saved state of a model of an equal unit.
    ///
    /// # Errors
    /// Bytes that no such model of this release has saved. Then nothing changes.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let unit = self.unit.clone();
        restore(self, &unit, bytes)?;
        self.outputs = self.inner.outputs();
        Ok(())
    }

    /// A cycle in which `rst_ni` is 0: all rays are lost, and requests get no response.
    pub fn reset(&mut self) {
        self.inner.reset();
        self.outputs = self.inner.outputs();
        self.awaited.fill(0);
        self.awaited_vectors.fill(0);
        self.undecided.fill(false);
        self.stalls = UnitStalls::default();
    }

    fn check_ray(&self, id: u64, ray: &UnitRay) -> Result<(), Error> {
        self.check_id("ray", id)?;
        ray.check(self.parameters).map_err(Error::Argument)
    }

    fn check_job(&self, id: u64, base: u32, address: u32) -> Result<(), Error> {
        let UnitParameters { address_width, search, .. } = self.parameters;
        let refused = |problem: String| Err(Error::Argument(problem));
        if search.0.is_none() {
            return refused("a job for a unit without searches, expected one with them".to_string());
        }
        self.check_id("job", id)?;
        if u64::from(base) >> (address_width - 32) != 0 {
            return refused(format!("a job with the base {base:#x}, expected at most {} bits", address_width - 32));
        }
        check_address(address)
    }

    fn check_id(&self, of: &str, id: u64) -> Result<(), Error> {
        let bits = self.parameters.id_width;
        if id > u64::MAX >> (64 - bits) {
            return Err(Error::Argument(format!("a {of} with the id {id}, expected at most {bits} bits")));
        }
        Ok(())
    }

    fn check_response(&self, awaited: &[u32], response: &Response<'_>) -> Result<(), Error> {
        let (tag, found) = (response.tag, response.beat.len());
        if awaited.get(tag as usize).is_none_or(|&awaited| awaited == 0) {
            let problem = format!("a beat with the tag {tag}, expected that of a request whose block is not complete");
            return Err(Error::Argument(problem));
        }
        let expected = self.parameters.memory_width as usize / 8;
        if found != expected {
            return Err(Error::Argument(format!("a beat of {found} bytes, expected {expected}")));
        }
        Ok(())
    }
}

/// A beat arrives, and a request is taken, whose block has so many beats.
fn await_beats(awaited: &mut [u32], response: Option<Response<'_>>, request: Option<BlockRequest>, beats: u32) {
    if let Some(awaited) = response.and_then(|response| awaited.get_mut(response.tag as usize)) {
        *awaited -= 1;
    }
    if let Some(awaited) = request.and_then(|request| awaited.get_mut(request.tag as usize)) {
        *awaited = beats;
    }
}
