//! Rays and hits of the unit as other languages have them in memory. Each structure has the layout of the C structure
//! `raypath_unit_…` of the same name.

use raypath_traversal::state::NO_INSTANCE;
use raypath_traversal::{RayRequest, Reply};

/// A ray as the traversal unit takes it, 44 bytes. The members are the ports of the ray's channel.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct UnitRay {
    /// The point at which the ray begins.
    pub origin: [f32; 3],
    /// The direction, of any length except 0.
    pub direction: [f32; 3],
    /// The least distance of a hit, in units of the direction's length.
    pub t_min: f32,
    /// The greatest distance of a hit; infinity reaches everything.
    pub t_max: f32,
    /// Not 0: the ray ends at the first block of triangles with a hit.
    pub any_hit: u32,
    /// 0, or `RAYPATH_CULL_BACK`, `RAYPATH_CULL_FRONT` or both: faces that are not hit.
    pub cull: u32,
    /// The child word of the scene's root.
    pub root: u32,
}

/// What the traversal unit returns for a ray, 44 bytes. The members are the ports of the hit's channel: without a hit,
/// all but `status`, `nodes` and `triangles` are 0.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct UnitHit {
    /// One of `RAYPATH_UNIT_…`: 0 miss, 1 hit, 2 ray refused, 3 error of the memory or of the scene.
    pub status: u32,
    /// The index of the triangle, as the scene has it.
    pub triangle: u32,
    /// The index of the triangle's instance, as the scene has it; `RAYPATH_UNIT_NO_INSTANCE` for a triangle in none, as
    /// all are in a unit without `instances`.
    pub instance: u32,
    /// The distance, in units of the direction's length.
    pub t: f32,
    /// The numerator of the distance.
    pub t_num: f32,
    /// The denominator of the distance; negative for a back face.
    pub t_denom: f32,
    /// With `barycentrics`, the weight of the triangle's first vertex at the hit; 0 otherwise. The weights of the three
    /// vertices add up to 1.
    pub u: f32,
    /// With `barycentrics`, the weight of the second vertex.
    pub v: f32,
    /// Whether the ray meets the back face: 0 or 1.
    pub back_face: u32,
    /// The nodes that the ray has read.
    pub nodes: u32,
    /// The triangles that the ray has read.
    pub triangles: u32,
}

/// The bits of [`UnitRay::cull`].
const CULL_BACK: u32 = 1;
const CULL_FRONT: u32 = 2;

impl UnitRay {
    /// An error if a member has a value that its port does not have.
    pub(super) fn check(&self) -> Result<(), String> {
        match self.cull {
            0..=3 => Ok(()),
            cull => Err(format!("cull is {cull}, expected 0 to 3")),
        }
    }
}

impl From<&UnitRay> for RayRequest {
    fn from(ray: &UnitRay) -> Self {
        let &UnitRay { origin, direction, t_min, t_max, any_hit, cull, root } = ray;
        let (cull_back, cull_front) = (cull & CULL_BACK != 0, cull & CULL_FRONT != 0);
        Self { origin, direction, t_min, t_max, any_hit: any_hit != 0, cull_back, cull_front, root }
    }
}

impl From<&Reply> for UnitHit {
    fn from(reply: &Reply) -> Self {
        let missed = Self { status: reply.status, nodes: reply.nodes, triangles: reply.triangles, ..Self::default() };
        let Some(hit) = reply.hit else { return missed };
        let [u, v] = hit.barycentric.unwrap_or_default();
        Self {
            triangle: hit.triangle,
            instance: hit.instance.unwrap_or(NO_INSTANCE),
            t: hit.t,
            t_num: hit.t_num,
            t_denom: hit.t_denom,
            u,
            v,
            back_face: hit.back_face.into(),
            ..missed
        }
    }
}
