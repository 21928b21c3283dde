//! Random values for stimuli.

use rand::{Rng, RngExt};
use raypath_float::Format;
use raypath_ops::{Aabb, Binary32, Ray};
use raypath_sim::numbers::edges;

/// A binary32 number for which operations have special rules, from [`edges`].
pub fn edge(rng: &mut impl Rng) -> f32 {
    let edges = edges(Format::BINARY32);
    f32::from_bits(edges[rng.random_range(0..edges.len())] as u32)
}

/// A number of either sign, with an exponent from `powers`. All exponents are equally likely.
pub fn spread(rng: &mut impl Rng, powers: std::ops::Range<i32>) -> f32 {
    let sign = if rng.random() { 1.0 } else { -1.0 };
    sign * rng.random_range(1.0_f32..2.0) * 2.0_f32.powi(rng.random_range(powers))
}

/// An array of three values from a generator.
pub fn three<T>(mut number: impl FnMut() -> T) -> [T; 3] {
    [number(), number(), number()]
}

/// An integer from -4 to 4, which makes ties frequent.
pub fn whole(rng: &mut impl Rng) -> f32 {
    rng.random_range(-4_i32..=4) as f32
}

/// A box with coordinates from -4 to 4. In 30 % of the boxes they are integers, and the box may be flat.
pub fn aabb(rng: &mut impl Rng) -> Aabb<Binary32> {
    let on_whole = rng.random_bool(0.3);
    let coordinate = |rng: &mut _| if on_whole { whole(rng) } else { RngExt::random_range(rng, -4.0_f32..4.0) };
    let (a, b) = (three(|| coordinate(rng)), three(|| coordinate(rng)));
    let axis = |pick: fn(f32, f32) -> f32| std::array::from_fn(|k| pick(a[k], b[k]));
    Aabb::new(axis(f32::min), axis(f32::max))
}

/// A ray towards a point from an origin near or far, sometimes along an axis. Three of eight rays have a finite extent.
pub fn ray_at(rng: &mut impl Rng, target: [f32; 3]) -> Ray<Binary32> {
    loop {
        let reach = 2.0_f32.powi(rng.random_range(0..12));
        let mut origin = match rng.random_range(0..4) {
            0 => three(|| whole(rng)),
            _ => three(|| rng.random_range(-reach..reach)),
        };
        for (from, to) in origin.iter_mut().zip(target) {
            if rng.random_bool(0.15) {
                *from = to;
            }
        }
        let stretch = 2.0_f32.powi(rng.random_range(-8..8));
        let mut direction: [f32; 3] = std::array::from_fn(|k| (target[k] - origin[k]) * stretch);
        for part in &mut direction {
            if *part == 0.0 && rng.random() {
                *part = -0.0;
            }
        }
        let extent = match rng.random_range(0..8) {
            0 => rng.random_range(0.0..1.0),
            1 => rng.random_range(0.0..2.0) / stretch,
            2 => 0.0,
            _ => f32::INFINITY,
        };
        // The direction is zero if the origin is the target.
        if let Ok(ray) = Ray::new(origin, direction, extent) {
            return ray;
        }
    }
}

/// A point of a box, sometimes a corner or a point on a face.
pub fn point_of(rng: &mut impl Rng, aabb: Aabb<Binary32>) -> [f32; 3] {
    [aabb.x, aabb.y, aabb.z].map(|slab| {
        let share = [0.0, 1.0, 0.5, rng.random_range(0.0..1.0)][rng.random_range(0..4)];
        let (min, max) = (f32::from(slab.min), f32::from(slab.max));
        (min + (max - min) * share).clamp(min, max)
    })
}
