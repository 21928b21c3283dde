//! The cycle-exact model of the unit.

use super::Unit;
use super::layout::{UnitHit, UnitRay};
use crate::Error;
use raypath_traversal::{self as unit, BlockRequest, Response, UnitCounts, UnitEngine, UnitParameters};

/// The cycle-exact model of a unit. In every cycle its outputs are those of the hardware.
///
/// A cycle consists of [`outputs`](Self::outputs), which depend on earlier cycles alone, then a [`step`](Self::step).
#[derive(Debug)]
pub struct UnitModel {
    inner: unit::UnitModel,
    outputs: unit::UnitOutputs,
    parameters: UnitParameters,
    /// For each tag, the beats of the requested block that have not arrived.
    awaited: Vec<u32>,
}

/// The inputs of the unit in a cycle.
#[derive(Debug, Clone, Copy, Default)]
pub struct UnitInputs<'i> {
    /// A ray that is offered, with its number. It is accepted if the outputs say so.
    pub ray: Option<(u64, &'i UnitRay)>,
    /// Whether the hit at the outputs is taken.
    pub hit_ready: bool,
    /// Whether the request at the outputs is taken.
    pub request_ready: bool,
    /// A beat of a requested block.
    pub response: Option<Response<'i>>,
}

/// The outputs of the unit in a cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnitOutputs {
    /// Whether a ray is accepted.
    pub ray_ready: bool,
    /// The number of a ray that has ended, and its hit.
    pub hit: Option<(u64, UnitHit)>,
    /// A request of a block.
    pub request: Option<BlockRequest>,
}

impl UnitModel {
    /// A unit after a reset.
    pub fn new(unit: &Unit) -> Self {
        let mut inner = unit::UnitModel::of(unit.netlist());
        let parameters = unit.parameters();
        Self { outputs: inner.outputs(), inner, awaited: vec![0; parameters.contexts as usize], parameters }
    }

    /// The outputs in this cycle.
    pub fn outputs(&self) -> UnitOutputs {
        let unit::UnitOutputs { ray_ready, hit, request, .. } = self.outputs;
        UnitOutputs { ray_ready, hit: hit.map(|(id, reply)| (id, (&reply).into())), request }
    }

    /// The clock edge that ends this cycle.
    ///
    /// # Errors
    /// A number of a ray with more bits than the unit has for it; a ray with a value that its port does not have; a
    /// beat for a tag without an outstanding request, or of another size than the memory's width. Then no cycle passes.
    pub fn step(&mut self, inputs: &UnitInputs<'_>) -> Result<(), Error> {
        if let Some((id, ray)) = inputs.ray {
            self.check_ray(id, ray)?;
        }
        if let Some(response) = &inputs.response {
            self.check_response(response)?;
        }
        let UnitInputs { ray, hit_ready, request_ready, response } = *inputs;
        let ray = ray.map(|(id, ray)| (id, ray.into()));
        self.inner.cycle(&unit::UnitInputs { ray, hit_ready, request_ready, response });
        if let Some(awaited) = response.and_then(|response| self.awaited.get_mut(response.tag as usize)) {
            *awaited -= 1;
        }
        if let Some(request) = self.outputs.request.filter(|_| request_ready)
            && let Some(awaited) = self.awaited.get_mut(request.tag as usize)
        {
            *awaited = 8 * self.parameters.step.node.block_bytes() / self.parameters.memory_width;
        }
        self.outputs = self.inner.outputs();
        Ok(())
    }

    /// Advances up to `limit` cycles in which no ray is offered, no beat arrives and nothing is taken, and stops in the
    /// first with a hit or a request. Returns the number of cycles.
    pub fn skip(&mut self, limit: u64) -> u64 {
        let mut passed = 0;
        while passed < limit && self.outputs.hit.is_none() && self.outputs.request.is_none() {
            let still = self.inner.idle(limit - passed);
            if still == 0 {
                self.inner.cycle(&unit::UnitInputs::default());
                self.outputs = self.inner.outputs();
            }
            passed += still.max(1);
        }
        passed
    }

    /// What the unit did since its last reset.
    pub fn counts(&self) -> UnitCounts {
        self.inner.counts()
    }

    /// A cycle in which `rst_ni` is 0: all rays are lost, and requests get no response.
    pub fn reset(&mut self) {
        self.inner.reset();
        self.outputs = self.inner.outputs();
        self.awaited.fill(0);
    }

    fn check_ray(&self, id: u64, ray: &UnitRay) -> Result<(), Error> {
        let bits = self.parameters.id_width;
        if id > u64::MAX >> (64 - bits) {
            return Err(Error::Argument(format!("a ray with the id {id}, expected at most {bits} bits")));
        }
        ray.check().map_err(Error::Argument)
    }

    fn check_response(&self, response: &Response<'_>) -> Result<(), Error> {
        let (tag, found) = (response.tag, response.beat.len());
        if self.awaited.get(tag as usize).is_none_or(|&awaited| awaited == 0) {
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
