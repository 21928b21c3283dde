//! Rays and boxes that touch or nearly touch.

use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use raypath_ops::{Binary32, Ray};

/// A ray and four boxes, each as its lower and upper corner.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// The ray.
    pub ray: Ray<Binary32>,
    /// The boxes.
    pub boxes: [[[f32; 3]; 2]; 4],
}

/// The magnitudes of directions' components whose inverses are normal numbers.
const INVERTIBLE: std::ops::RangeInclusive<f32> = f32::from_bits(1 << 23)..=f32::from_bits(253 << 23);

/// A random case: rays in faces, along edges and through corners, along axes with ±0, from far away; boxes that are
/// flat, empty or around the origin; extents near the box's entry.
pub fn draw(rng: &mut ChaCha8Rng) -> Case {
    loop {
        let numbers = Numbers::draw(rng);
        let mut origin: [f32; 3] = std::array::from_fn(|_| (numbers.size * numbers.coordinate(rng)) as f32);
        if rng.random_range(0..8) == 0 {
            origin = origin.map(|x| x * 2_f32.powi(20));
        }
        let direction: [f32; 3] = std::array::from_fn(|_| (numbers.length * numbers.component(rng)) as f32);
        if direction.iter().any(|d| *d != 0.0 && !INVERTIBLE.contains(&d.abs())) {
            continue;
        }
        let reach = [0.0, 0.5, 1.0, 1.0, 3.0, -1.0][rng.random_range(0..6)] * numbers.size / numbers.length;
        let extent = extent(rng, reach);
        let Ok(ray) = Ray::new(origin, direction, extent) else { continue };
        let boxes = std::array::from_fn(|i| {
            let reach = if i < 2 { reach } else { reach * rng.random_range(0.0..2.0) };
            numbers.aabb(rng, origin, direction, reach)
        });
        return Case { ray, boxes };
    }
}

/// The numbers that a case is made of.
struct Numbers {
    /// Whether they are small multiples of 1/2 and powers of two, so that no operation rounds.
    lattice: bool,
    /// The unit of coordinates.
    size: f64,
    /// The unit of the direction's components.
    length: f64,
}

impl Numbers {
    fn draw(rng: &mut ChaCha8Rng) -> Self {
        let is_wide = rng.random_range(0..4) == 0;
        let mut power = |low: i32, high: i32| if is_wide { f64::from(rng.random_range(low..high)).exp2() } else { 1.0 };
        let (size, length) = (power(-100, 60), power(-60, 100));
        Self { lattice: rng.random_range(0..4) == 0, size, length }
    }

    fn coordinate(&self, rng: &mut ChaCha8Rng) -> f64 {
        if self.lattice { f64::from(rng.random_range(-8..=8)) / 2.0 } else { rng.random_range(-4.0..4.0) }
    }

    fn component(&self, rng: &mut ChaCha8Rng) -> f64 {
        let size = match rng.random_range(0..16) {
            0..3 => 0.0,
            3 => rng.random_range(-40.0..-10.0_f64).exp2(),
            _ if self.lattice => [0.5, 1.0, 2.0, 4.0][rng.random_range(0..4)],
            _ => rng.random_range(0.01..4.0),
        };
        if rng.random() { -size } else { size }
    }

    /// A box near the ray's point at the distance `reach`. The point lies in some of the box's faces, so that the ray
    /// enters or leaves there, touches an edge or corner, or runs in a face.
    fn aabb(&self, rng: &mut ChaCha8Rng, origin: [f32; 3], direction: [f32; 3], reach: f64) -> [[f32; 3]; 2] {
        let slabs: [[f32; 2]; 3] = std::array::from_fn(|axis| {
            let at = (f64::from(origin[axis]) + reach * f64::from(direction[axis])) as f32;
            let mut beside = || (self.size * self.coordinate(rng).abs()) as f32;
            let (below, above) = (at - beside(), at + beside());
            let [low, high] = match rng.random_range(0..6) {
                0 | 1 => [at, above],
                2 | 3 => [below, at],
                4 => [below, above],
                _ => [above, above + (self.size * rng.random_range(0.0..1.0)) as f32],
            };
            match rng.random_range(0..16) {
                0 | 1 => [low, low],
                2 => [high, low],
                _ => [low, high],
            }
        });
        [slabs.map(|[low, _]| low), slabs.map(|[_, high]| high)]
    }
}

/// A random extent: infinity, near the distance `reach`, or any.
fn extent(rng: &mut ChaCha8Rng, reach: f64) -> f32 {
    let about = (reach.abs() as f32).max(0.0);
    match rng.random_range(0..8) {
        0 => f32::from_bits(about.to_bits() + rng.random_range(0..4)),
        1 => f32::from_bits(about.to_bits().saturating_sub(rng.random_range(0..4))),
        2 => [0.0, f32::MAX, f32::MIN_POSITIVE][rng.random_range(0..3)],
        3 => about * rng.random_range(0.0..4.0),
        _ => f32::INFINITY,
    }
}
