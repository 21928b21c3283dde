//! Wrong implementations of the distance of a ray and a triangle: the negative control of `triangle-distance`.

use super::implementations::datapath;
use super::triangle_distances::TriangleResult;
use raypath_ops::{Binary32, Ray, Rules};

/// A wrong implementation and its name.
pub type Named = (&'static str, fn(&Ray<Binary32>, [[f32; 3]; 3]) -> TriangleResult);

/// The wrong implementations: inputs and results with too few bits, and a missing factor.
pub const WRONG: [Named; 4] = [
    ("shear constants of 16 bits", |ray, corners| with_shear(ray, corners, |shear| shear.map(|x| truncate(x, 16)))),
    ("depths without the factor of the shear", |ray, corners| with_shear(ray, corners, |[x, y, _]| [x, y, 1.0])),
    ("t_num of 16 bits", |ray, corners| {
        let right = with_shear(ray, corners, |shear| shear);
        TriangleResult { t_num: truncate(right.t_num, 16), ..right }
    }),
    ("t_denom of 16 bits", |ray, corners| {
        let right = with_shear(ray, corners, |shear| shear);
        TriangleResult { t_denom: truncate(right.t_denom, 16), ..right }
    }),
];

/// The datapath's result for a ray with other shear constants.
fn with_shear(ray: &Ray<Binary32>, corners: [[f32; 3]; 3], shear: impl Fn([f32; 3]) -> [f32; 3]) -> TriangleResult {
    let ray = Ray { shear: shear(ray.shear.into()).into(), ..*ray };
    TriangleResult::of(datapath(Rules::Paper, &ray, corners))
}

/// The number with a significand of `bits` bits, rounded towards zero.
pub fn truncate(number: f32, bits: u32) -> f32 {
    f32::from_bits(number.to_bits() >> (24 - bits) << (24 - bits))
}
