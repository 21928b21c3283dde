//! The functional model of the unit: a ray goes in, its hit comes out, without time.

use crate::answers::{Answers, quotient};
use crate::candidate::{Candidate, Verdict};
use crate::descent::Trail;
use crate::query::InstanceWords;
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
    fn block(&self, address: u64, bytes: u32) -> Result<&[u8], MemoryError>;
}

/// The error of an address without a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("there is no block at address {0:#x}")]
pub struct MemoryError(pub u64);

impl Memory for [u8] {
    #[inline]
    fn block(&self, address: u64, bytes: u32) -> Result<&[u8], MemoryError> {
        let rest = usize::try_from(address).ok().and_then(|first| self.get(first..));
        let block = rest.and_then(|rest| rest.get(..bytes as usize));
        block.filter(|_| address & u64::from(bytes - 1) == 0).ok_or(MemoryError(address))
    }
}

/// A ray as the unit takes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayRequest {
    /// The point at which the ray begins.
    pub origin: [f32; 3],
    /// The direction, of any length that can be inverted.
    pub direction: [f32; 3],
    /// Hits count beyond this distance, in units of the direction's length.
    pub t_min: f32,
    /// Hits count below this distance; infinity reaches everything.
    pub t_max: f32,
    /// The bits of [`ray_flags`](crate::ray_flags) that are set, of the ten that there are.
    pub flags: u32,
    /// With instances and [`Queries::Flags`](crate::Queries::Flags): instances count whose mask has a bit of it.
    pub cull_mask: u8,
    /// The child word of the scene's root.
    pub root: u32,
    /// Bits 63 to 32 of every address that the ray reads, the only ones that no child word has. They are put before
    /// those of a child word, not added: hardware needs no adder and no carry, and a scene lies within a window of
    /// 4 GiB, which a driver can move as a whole. 0 in a unit with addresses of 32 bits.
    pub base: u32,
}

impl RayRequest {
    /// A ray from the origin along z to its first hit, in a scene without a root.
    pub const NONE: Self = Self {
        origin: [0.0; 3],
        direction: [0.0, 0.0, 1.0],
        t_min: 0.0,
        t_max: f32::INFINITY,
        flags: 0,
        cull_mask: u8::MAX,
        root: 0,
        base: 0,
    };

    /// The address of a block of which child words have the lower 32 bits.
    #[inline(always)]
    pub(crate) fn address(base: u32, lower: u32) -> u64 {
        u64::from(base) << 32 | u64::from(lower)
    }
}

/// The hit of a ray.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Hit {
    /// The index of the triangle in its geometry.
    pub primitive: u32,
    /// The index of its geometry; 0 with [`Queries::None`](crate::Queries::None).
    pub geometry: u32,
    /// The distance `t_num / t_denom`, in units of the direction's length.
    pub t: f32,
    /// The numerator of the distance.
    pub t_num: f32,
    /// The denominator of the distance; negative if the vertices run clockwise as the ray's origin sees them.
    pub t_denom: f32,
    /// The ray meets the back face, as seen in the space of the object.
    pub back_face: bool,
    /// With the feature `barycentrics`: the weights of the vertices b and c at the hit; the three weights add up to 1.
    pub barycentric: Option<[f32; 2]>,
    /// The instance of the triangle, if it is in one.
    pub instance: Option<HitInstance>,
}

/// The instance of a hit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct HitInstance {
    /// Its index.
    pub index: u32,
    /// Its custom index; 0 with [`Queries::None`](crate::Queries::None).
    pub custom_index: u32,
    /// Its offset into the shader table; 0 with [`Queries::None`](crate::Queries::None).
    pub shader_offset: u32,
}

/// What the unit returns for a ray.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Reply {
    /// One of [`status`].
    pub status: u32,
    /// The hit: the closest, of several at the same distance that of the lowest instance, geometry and index; with
    /// [`TERMINATE_ON_FIRST_HIT`](crate::ray_flags::TERMINATE_ON_FIRST_HIT) the closest of the first block with a hit.
    /// There is none after an error.
    pub hit: Option<Hit>,
    /// The nodes that were fetched.
    pub nodes: u32,
    /// The triangles that were fetched.
    pub triangles: u32,
}

state! {
    Reply { status, hit, nodes, triangles }
    Hit { primitive, geometry, t, t_num, t_denom, back_face, barycentric, instance }
    HitInstance { index, custom_index, shader_offset }
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

    /// Traces a ray. Candidates have the verdict of [`Verdict::without_shaders`].
    pub fn trace(&mut self, memory: &(impl Memory + ?Sized), ray: &RayRequest) -> Reply {
        self.trace_with(memory, ray, &mut Verdict::without_shaders)
    }

    /// Traces a ray whose user decides about candidates.
    pub fn trace_with(
        &mut self,
        memory: &(impl Memory + ?Sized),
        ray: &RayRequest,
        decide: &mut dyn FnMut(&Candidate) -> Verdict,
    ) -> Reply {
        if let Some(reply) = self.trail.trace(&self.answers, self.parameters, memory, ray, decide) {
            return reply;
        }
        self.trace_by_steps(memory, ray, decide)
    }

    /// As [`trace_with`](Self::trace_with), step by step as the hardware does.
    pub fn trace_by_steps(
        &mut self,
        memory: &(impl Memory + ?Sized),
        ray: &RayRequest,
        decide: &mut dyn FnMut(&Candidate) -> Verdict,
    ) -> Reply {
        self.walk.begin(&self.answers, self.parameters, ray);
        while self.walk.step(&self.answers, self.parameters, memory).kind != AskedKind::Nothing {
            if let Some(candidate) = self.walk.candidate(self.parameters) {
                self.walk.decide(decide(&candidate));
            }
        }
        self.walk.reply(self.parameters)
    }

    /// A ray that waits for its user at each candidate.
    pub fn query(&self, ray: &RayRequest) -> Query {
        let mut walk = Walk::new(&self.answers);
        walk.begin(&self.answers, self.parameters, ray);
        Query { parameters: self.parameters, answers: self.answers, walk }
    }
}

/// A ray that waits for its user at each candidate.
#[derive(Debug, Clone)]
pub struct Query {
    parameters: StepParameters,
    answers: Answers,
    walk: Walk,
}

impl Query {
    /// Goes on to the next candidate, or to the end of the ray, where there is none. The candidate before is ignored if
    /// [`answer`](Self::answer) did not say otherwise.
    pub fn proceed(&mut self, memory: &(impl Memory + ?Sized)) -> Option<Candidate> {
        while self.walk.asked().kind != AskedKind::Nothing {
            self.walk.step(&self.answers, self.parameters, memory);
            self.walk.decide(Verdict::IGNORE);
            if let Some(candidate) = self.walk.candidate(self.parameters) {
                return Some(candidate);
            }
        }
        None
    }

    /// Decides about the candidate.
    pub fn answer(&mut self, verdict: Verdict) {
        self.walk.decide(verdict);
    }

    /// The reply of a ray that has ended; none before.
    pub fn reply(&self) -> Option<Reply> {
        (self.walk.asked().kind == AskedKind::Nothing).then(|| self.walk.reply(self.parameters))
    }
}

impl HitInstance {
    /// What a unit with these features reports of an instance.
    pub(crate) fn of(words: InstanceWords<Binary32>, features: UnitFeatures) -> Option<Self> {
        let InstanceWords { index, custom_index, shader_offset } = words;
        let of_flags = |word: u32| if features.has_flags() { word } else { 0 };
        let (custom_index, shader_offset) = (of_flags(custom_index.value), of_flags(shader_offset.value));
        Self { index: index.value, custom_index, shader_offset }.or_none()
    }

    /// It, unless its index is that of none.
    pub(crate) fn or_none(self) -> Option<Self> {
        (self.index != NO_INSTANCE).then_some(self)
    }
}

impl Reply {
    /// The reply for a ray that ends in this state.
    pub(crate) fn of(state: &RayState<Binary32>, status: u32, features: UnitFeatures) -> Self {
        let weight = |numerator| quotient(numerator, state.t_denom).into();
        let hit = status::is_hit(status).then(|| Hit {
            primitive: state.primitive.value,
            geometry: if features.has_flags() { state.geometry.value } else { 0 },
            t: state.extent.into(),
            t_num: state.t_num.into(),
            t_denom: state.t_denom.into(),
            back_face: state.back_face.into(),
            barycentric: features.barycentrics.then(|| [weight(state.u_num), weight(state.v_num)]),
            instance: HitInstance::of(state.hit_instance, features),
        });
        Self { status, hit, nodes: state.nodes.value, triangles: state.triangles.value }
    }
}
