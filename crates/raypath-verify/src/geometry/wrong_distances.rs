//! Wrong ways to compute where a ray meets a triangle. `triangle-distance` must refute each of them.

use super::distances::Answer;
use super::intersect::datapath;
use raypath_ops::{Binary32, Ray, Rules};

/// A wrong implementation and its name.
pub type Named = (&'static str, fn(&Ray<Binary32>, [[f32; 3]; 3]) -> Answer);

/// The wrong implementations: inputs and results that are rounded too coarsely, and a factor that is left out.
pub const WRONG: [Named; 4] = [
    ("shear constants of 20 bits", |ray, corners| with_shear(ray, corners, |shear| shear.map(|x| truncate(x, 20)))),
    ("depths without the factor of the shear", |ray, corners| with_shear(ray, corners, |[x, y, _]| [x, y, 1.0])),
    ("t_num of 18 bits", |ray, corners| {
        let right = with_shear(ray, corners, |shear| shear);
        Answer { t_num: truncate(right.t_num, 18), ..right }
    }),
    ("t_denom of 18 bits", |ray, corners| {
        let right = with_shear(ray, corners, |shear| shear);
        Answer { t_denom: truncate(right.t_denom, 18), ..right }
    }),
];

/// The datapath's answer for a ray with other shear constants.
fn with_shear(ray: &Ray<Binary32>, corners: [[f32; 3]; 3], shear: impl Fn([f32; 3]) -> [f32; 3]) -> Answer {
    let ray = Ray { shear: shear(ray.shear.into()).into(), ..*ray };
    Answer::of(datapath(Rules::Paper, &ray, corners))
}

/// The number with a significand of `bits` bits, rounded towards zero.
pub fn truncate(number: f32, bits: u32) -> f32 {
    f32::from_bits(number.to_bits() >> (24 - bits) << (24 - bits))
}
