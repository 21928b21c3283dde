//! Rays that wait for their user at each candidate.

use super::Unit;
use super::layout::{UnitHit, UnitRay};
use crate::Error;
use raypath_traversal::state::NO_INSTANCE;
use raypath_traversal::{self as unit, Candidate, HitInstance, Queries, Verdict};

/// Something that a ray may hit, about which its user decides, 80 bytes: a triangle that is not opaque, or a procedural
/// box. The members are the ports of the channel of candidates; for a box, all but its indices and the ray are 0.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct UnitCandidate {
    /// 1 for a procedural box, 0 for a triangle.
    pub is_box: u32,
    /// 1 if it counts as opaque, as boxes may.
    pub is_opaque: u32,
    /// The index in its geometry.
    pub primitive: u32,
    /// The index of its geometry.
    pub geometry: u32,
    /// The index of its instance; `RAYPATH_UNIT_NO_INSTANCE` in none.
    pub instance: u32,
    /// The custom index of its instance.
    pub custom_index: u32,
    /// The offset of its instance into the shader table.
    pub shader_offset: u32,
    /// The distance, in units of the direction's length.
    pub t: f32,
    /// The numerator of the distance.
    pub t_num: f32,
    /// The denominator of the distance.
    pub t_denom: f32,
    /// With `barycentrics`, the weight of the triangle's second vertex.
    pub u: f32,
    /// With `barycentrics`, the weight of the third vertex.
    pub v: f32,
    /// 1 if the ray meets the back face.
    pub back_face: u32,
    /// The index of the ray among those that were given.
    pub ray: u32,
    /// The origin of the ray in the space of its instance; in none, that of the ray itself.
    pub origin: [f32; 3],
    /// The direction of the ray in that space, which is not normalised.
    pub direction: [f32; 3],
}

/// What a user decides about a candidate, 12 bytes. All members 0 ignore it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct UnitVerdict {
    /// Not 0: it becomes the closest hit.
    pub accept: u32,
    /// Not 0: the ray ends, with its closest hit.
    pub end: u32,
    /// The distance of the hit of a box. It counts from `t_min` up to the closest hit or `t_max`; beyond, nothing is
    /// accepted.
    pub t: f32,
}

/// A ray that waits for its user at each candidate.
#[derive(Debug, Clone)]
pub struct UnitQuery(unit::Query);

impl UnitQuery {
    /// Goes on through a scene to the next candidate, or to the end of the ray, where there is none. A candidate without
    /// an [`answer`](Self::answer) is ignored.
    pub fn proceed(&mut self, scene: &[u8]) -> Option<UnitCandidate> {
        self.0.proceed(scene).as_ref().map(UnitCandidate::from)
    }

    /// Decides about the candidate.
    pub fn answer(&mut self, verdict: UnitVerdict) {
        self.0.answer(verdict.into());
    }

    /// The hit of a ray that has ended; none before.
    pub fn hit(&self) -> Option<UnitHit> {
        self.0.reply().as_ref().map(UnitHit::from)
    }
}

impl Unit {
    /// A ray that waits for its user at each candidate.
    ///
    /// # Errors
    /// A ray with a value that its port does not have; a unit without `queries = "full"`.
    pub fn query(&self, ray: &UnitRay) -> Result<UnitQuery, Error> {
        self.check_queries(std::slice::from_ref(ray))?;
        Ok(UnitQuery(self.functional.query(&ray.into())))
    }

    /// The errors of [`query`](Self::query) for these rays.
    ///
    /// # Errors
    /// Those of [`query`](Self::query).
    pub fn check_queries(&self, rays: &[UnitRay]) -> Result<(), Error> {
        let queries = self.parameters().step.features.queries;
        if queries != Queries::Full {
            return Err(Error::Argument(format!("a query of a unit with queries {queries}, expected full")));
        }
        self.check(rays)
    }

    /// As [`trace`](Self::trace), and `decide` decides about the candidates of each ray, with its index.
    ///
    /// # Errors
    /// Those of [`trace`](Self::trace).
    pub fn trace_with(
        &self,
        scene: &[u8],
        rays: &[UnitRay],
        hits: &mut [UnitHit],
        decide: &mut dyn FnMut(&UnitCandidate) -> UnitVerdict,
    ) -> Result<(), Error> {
        self.check(rays)?;
        crate::datapath::same_length("hits", hits.len(), "rays", rays.len())?;
        let mut model = self.functional.clone();
        for ((ray, hit), number) in rays.iter().zip(hits).zip(0..) {
            let mut decide = |candidate: &Candidate| {
                Verdict::from(decide(&UnitCandidate { ray: number, ..UnitCandidate::from(candidate) }))
            };
            *hit = (&model.trace_with(scene, &ray.into(), &mut decide)).into();
        }
        Ok(())
    }
}

impl From<&Candidate> for UnitCandidate {
    fn from(&Candidate { hit, is_box, is_opaque, origin, direction }: &Candidate) -> Self {
        let none = HitInstance { index: NO_INSTANCE, ..HitInstance::default() };
        let HitInstance { index, custom_index, shader_offset } = hit.instance.unwrap_or(none);
        let [u, v] = hit.barycentric.unwrap_or_default();
        Self {
            is_box: is_box.into(),
            is_opaque: is_opaque.into(),
            primitive: hit.primitive,
            geometry: hit.geometry,
            instance: index,
            custom_index,
            shader_offset,
            t: hit.t,
            t_num: hit.t_num,
            t_denom: hit.t_denom,
            u,
            v,
            back_face: hit.back_face.into(),
            ray: 0,
            origin,
            direction,
        }
    }
}

impl From<UnitVerdict> for Verdict {
    fn from(UnitVerdict { accept, end, t }: UnitVerdict) -> Self {
        Self { accepts: accept != 0, ends: end != 0, t }
    }
}
