//! What a ray asks its user: candidates, and the user's verdicts.

use crate::model::Hit;
use raypath_model::state;

/// Something that a ray may hit, about which its user decides: a triangle that is not opaque, or a procedural box.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Candidate {
    /// What the hit would be. A box has its indices alone, with 0 in the place of numbers.
    pub hit: Hit,
    /// It is a procedural box.
    pub is_box: bool,
    /// It counts as opaque, as boxes may.
    pub is_opaque: bool,
    /// The origin of the ray with which it was tested: in an instance, that in the space of the object.
    pub origin: [f32; 3],
    /// The direction of that ray.
    pub direction: [f32; 3],
}

/// What a user decides about a candidate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Verdict {
    /// It becomes the closest hit.
    pub accepts: bool,
    /// The ray ends, with the closest hit.
    pub ends: bool,
    /// The distance of the hit of a box. It counts from `t_min` up to the closest hit or `t_max`; beyond, the verdict
    /// accepts nothing.
    pub t: f32,
}

impl Verdict {
    /// It is no hit.
    pub const IGNORE: Self = Self { accepts: false, ends: false, t: 0.0 };
    /// It is a hit, of a triangle at its own distance.
    pub const ACCEPT: Self = Self { accepts: true, ..Self::IGNORE };

    /// The verdict where there are no shaders: triangles are hit, and boxes are not.
    pub fn without_shaders(candidate: &Candidate) -> Self {
        if candidate.is_box { Self::IGNORE } else { Self::ACCEPT }
    }
}

state! { Verdict { accepts, ends, t } }
