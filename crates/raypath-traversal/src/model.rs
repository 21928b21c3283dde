//! The functional model of the unit: a ray goes in, its hit comes out, without time.

use crate::answers::{Answers, quotient};
use crate::descent::Trail;
use crate::state::{NO_INSTANCE, RayState, status};
use crate::step::{StepParameters, UnitFeatures};
use crate::walk::{AskedKind, Walk};
use raypath_model::state;
use raypath_ops::{Binary32, Rules};
use thiserror::Error;

/// The memory that a unit reads.
pub trait Memory {
    /// The block of so many bytes, a power of two, at an address that is a multiple of them.
    ///
    /// # Errors
    /// There is no block at the address.
    fn block(&self, address: u32, bytes: u32) -> Result<&[u8], MemoryError>;
}

/// The error of an address without a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("there is no block at address {0:#x}")]
pub struct MemoryError(pub u32);

impl Memory for [u8] {
    #[inline]
    fn block(&self, address: u32, bytes: u32) -> Result<&[u8], MemoryError> {
        let block = self.get(address as usize..).and_then(|rest| rest.get(..bytes as usize));
        block.filter(|_| address & (bytes - 1) == 0).ok_or(MemoryError(address))
    }
}

/// A ray as the unit takes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayRequest {
    /// The point at which the ray begins.
    pub origin: [f32; 3],
    /// The direction, of any length that can be inverted.
    pub direction: [f32; 3],
    /// The least distance of a hit, in units of the direction's length.
    pub t_min: f32,
    /// The greatest distance of a hit; infinity reaches everything.
    pub t_max: f32,
    /// The ray ends at the first block of triangles with a hit.
    pub any_hit: bool,
    /// Back faces are not hit.
    pub cull_back: bool,
    /// Front faces are not hit.
    pub cull_front: bool,
    /// The child word of the scene's root.
    pub root: u32,
}

/// The hit of a ray.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Hit {
    /// The index of the triangle.
    pub triangle: u32,
    /// The distance `t_num / t_denom`, in units of the direction's length.
    pub t: f32,
    /// The numerator of the distance.
    pub t_num: f32,
    /// The denominator of the distance; negative for a back face.
    pub t_denom: f32,
    /// The ray meets the back face, as seen in the space of the object.
    pub back_face: bool,
    /// With the feature `barycentrics`: the weights of the vertices a and b at the hit; the three weights add up to 1.
    pub barycentric: Option<[f32; 2]>,
    /// The index of the instance of the triangle, if it is in one.
    pub instance: Option<u32>,
}

/// What the unit returns for a ray.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Reply {
    /// One of [`status`].
    pub status: u32,
    /// The hit: the closest, of several at the same distance that of the lowest index; with `any_hit` the closest of
    /// the first block with a hit. There is none after an error.
    pub hit: Option<Hit>,
    /// The nodes that were fetched.
    pub nodes: u32,
    /// The triangles that were fetched.
    pub triangles: u32,
}

state! {
    Reply { status, hit, nodes, triangles }
    Hit { triangle, t, t_num, t_denom, back_face, barycentric, instance }
}

/// The functional model of the unit.
#[derive(Debug, Clone)]
pub struct Unit {
    parameters: StepParameters,
    answers: Answers,
    walk: Walk,
    trail: Trail,
}

impl Unit {
    /// A unit with these rules for special cases.
    pub fn new(rules: Rules, parameters: StepParameters) -> Self {
        let answers = Answers::new(rules, parameters);
        Self { parameters, walk: Walk::new(&answers), trail: Trail::new(), answers }
    }

    /// Traces a ray.
    pub fn trace(&mut self, memory: &(impl Memory + ?Sized), ray: &RayRequest) -> Reply {
        if let Some(reply) = self.trail.trace(&self.answers, self.parameters, memory, ray) {
            return reply;
        }
        self.trace_by_steps(memory, ray)
    }

    /// As [`trace`](Self::trace), step by step as the hardware does.
    pub fn trace_by_steps(&mut self, memory: &(impl Memory + ?Sized), ray: &RayRequest) -> Reply {
        self.walk.begin(&self.answers, ray);
        while self.walk.step(&self.answers, self.parameters, memory).kind != AskedKind::Nothing {}
        self.walk.reply(self.parameters)
    }
}

/// The instance of an index, which a hit in none does not have.
pub(crate) fn instance_of(index: u32) -> Option<u32> {
    (index != NO_INSTANCE).then_some(index)
}

impl Reply {
    /// The reply for a ray that ends in this state.
    pub(crate) fn of(state: &RayState<Binary32>, status: u32, features: UnitFeatures) -> Self {
        let weight = |numerator| quotient(numerator, state.t_denom).into();
        let hit = (status == status::HIT).then(|| Hit {
            triangle: state.triangle.value,
            t: state.extent.into(),
            t_num: state.t_num.into(),
            t_denom: state.t_denom.into(),
            back_face: state.back_face.into(),
            barycentric: features.barycentrics.then(|| [weight(state.u_num), weight(state.v_num)]),
            instance: instance_of(state.hit_instance.value),
        });
        Self { status, hit, nodes: state.nodes.value, triangles: state.triangles.value }
    }
}
