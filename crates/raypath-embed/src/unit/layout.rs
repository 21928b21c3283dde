//! Rays and hits of the unit as other languages have them in memory. Each structure has the layout of the C structure
//! `raypath_unit_…` of the same name.

use raypath_traversal::state::NO_INSTANCE;
use raypath_traversal::{HitInstance, RayRequest, Reply, UnitParameters, ray_flags};

/// A ray as the traversal unit takes it, 48 bytes. The members are the ports of the ray's channel.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct UnitRay {
    /// The point at which the ray begins.
    pub origin: [f32; 3],
    /// The direction, of any length except 0.
    pub direction: [f32; 3],
    /// Hits count beyond this distance, in units of the direction's length.
    pub t_min: f32,
    /// Hits count below this distance; infinity reaches everything.
    pub t_max: f32,
    /// The bits `RAYPATH_RAY_…` that are set, which are those of SPIR-V's `RayFlags`.
    pub flags: u32,
    /// With `instances` and `queries`: instances count whose mask has a bit of it, 0 to 255. 255 is usual, and 0 hits no
    /// instance.
    pub cull_mask: u32,
    /// The child word of the scene's root.
    pub root: u32,
    /// With `address-width` above 32: the bits of every address above its lower 32. A scene lies within the 4 GiB that
    /// it selects. 0 in other units.
    pub base: u32,
}

/// What the traversal unit returns for a ray, 56 bytes. The members are the ports of the hit's channel: without a hit,
/// all but `status`, `nodes` and `triangles` are 0.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct UnitHit {
    /// One of `RAYPATH_UNIT_…`: 0 miss, 1 hit of a triangle, 2 of a box, 3 ray refused, 4 error of the memory, 5 error
    /// of the scene, 6 limit of work.
    pub status: u32,
    /// The index of the triangle in its geometry.
    pub primitive: u32,
    /// The index of the triangle's instance, as the scene has it; `RAYPATH_UNIT_NO_INSTANCE` for a triangle in none, as
    /// all are in a unit without `instances`.
    pub instance: u32,
    /// The distance, in units of the direction's length.
    pub t: f32,
    /// The numerator of the distance.
    pub t_num: f32,
    /// The denominator of the distance; negative if the vertices run clockwise as the ray's origin sees them.
    pub t_denom: f32,
    /// With `barycentrics`, the weight of the triangle's second vertex at the hit; 0 otherwise. The weights of the
    /// three vertices add up to 1.
    pub u: f32,
    /// With `barycentrics`, the weight of the third vertex.
    pub v: f32,
    /// Whether the ray meets the back face: 0 or 1.
    pub back_face: u32,
    /// The nodes that the ray has read.
    pub nodes: u32,
    /// The triangles that the ray has read.
    pub triangles: u32,
    /// With `queries`, the index of the triangle's geometry; 0 otherwise.
    pub geometry: u32,
    /// With `instances` and `queries`, the custom index of the triangle's instance; 0 otherwise.
    pub custom_index: u32,
    /// With `instances` and `queries`, the offset of that instance into the shader table; 0 otherwise.
    pub shader_offset: u32,
}

impl UnitRay {
    /// An error if a member has a value that its port in this unit does not have.
    pub(super) fn check(&self, unit: UnitParameters) -> Result<(), String> {
        let Self { flags, cull_mask, base, .. } = *self;
        for (name, value, most) in [("flags", flags, ray_flags::ALL), ("cull_mask", cull_mask, u8::MAX.into())] {
            if value > most {
                return Err(format!("{name} is {value}, expected 0 to {most}"));
            }
        }
        let (most, bits) = (unit.greatest_base(), unit.address_width);
        if base > most {
            return Err(format!("base is {base}, expected 0 to {most} with addresses of {bits} bits"));
        }
        Ok(())
    }
}

impl From<&UnitRay> for RayRequest {
    fn from(ray: &UnitRay) -> Self {
        let &UnitRay { origin, direction, t_min, t_max, flags, cull_mask, root, base } = ray;
        Self { origin, direction, t_min, t_max, flags, cull_mask: cull_mask as u8, root, base }
    }
}

impl From<&Reply> for UnitHit {
    fn from(reply: &Reply) -> Self {
        let missed = Self { status: reply.status, nodes: reply.nodes, triangles: reply.triangles, ..Self::default() };
        let Some(hit) = reply.hit else { return missed };
        let [u, v] = hit.barycentric.unwrap_or_default();
        let instance = hit.instance.unwrap_or(HitInstance { index: NO_INSTANCE, ..HitInstance::default() });
        Self {
            primitive: hit.primitive,
            instance: instance.index,
            t: hit.t,
            t_num: hit.t_num,
            t_denom: hit.t_denom,
            u,
            v,
            back_face: hit.back_face.into(),
            geometry: hit.geometry,
            custom_index: instance.custom_index,
            shader_offset: instance.shader_offset,
            ..missed
        }
    }
}
