//! The added operations that test no boxes against rays, by their definitions in `docs/reference/operations.md`.

use super::inputs::{Inputs, Slab};
use super::mistake::Mistake;
use super::number::{Arithmetic, Number};
use std::cmp::Ordering;

/// The child of a key: that of the separators that are not greater than it. In an ascending list, those come first, so
/// that bisection counts them. For separators out of order its result is defined by its steps.
pub fn child(arithmetic: &Arithmetic, inputs: &Inputs) -> u64 {
    let is_right = if arithmetic.makes(Mistake::StrictKeys) { Ordering::is_lt } else { Ordering::is_le };
    let is_reached = |separator: &Number| separator.order(inputs.key).is_some_and(is_right);
    let (mut first, mut step) = (0, 32);
    while step > 0 {
        if inputs.separators.get(first + step - 1).is_some_and(is_reached) {
            first += step;
        }
        step /= 2;
    }
    first as u64
}

/// The boxes that contain the point, bit i for box i.
pub fn inside(arithmetic: &Arithmetic, inputs: &Inputs) -> u64 {
    let is_right = if arithmetic.makes(Mistake::OpenPoints) { Ordering::is_lt } else { Ordering::is_le };
    let is_in = |a: Number, b| a.order(b).is_some_and(is_right);
    let is_inside = |bounds: &[Slab<Number>; 3]| {
        bounds.iter().zip(inputs.point).all(|(slab, x)| is_in(slab.min, x) && is_in(x, slab.max))
    };
    inputs.boxes.iter().rev().fold(0, |mask, bounds| mask << 1 | u64::from(is_inside(bounds)))
}

/// The quadratic equation of a ray and a sphere.
#[derive(Debug)]
pub struct Sphere {
    pub a: Number,
    pub b: Number,
    pub c: Number,
    pub discriminant: Number,
    pub is_hit: bool,
}

impl Sphere {
    pub fn of(arithmetic: &Arithmetic, inputs: &Inputs) -> Self {
        let d = inputs.direction;
        let f = std::array::from_fn(|axis| arithmetic.sub(inputs.centre[axis], inputs.origin[axis]));
        let normal = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| arithmetic.cross([f[i], d[j]], [f[j], d[i]]));
        let square = arithmetic.mul(inputs.radius, inputs.radius);
        let (a, b) = (arithmetic.dot(d, d), arithmetic.dot(f, d));
        let c = arithmetic.sub(arithmetic.dot(f, f), square);
        let discriminant = arithmetic.sub(arithmetic.mul(square, a), arithmetic.dot(normal, normal));
        let starts_inside = !c.is_above_zero() || arithmetic.makes(Mistake::SpheresBehind);
        let is_hit = ![a, b, c, discriminant].contains(&Number::Nan)
            && discriminant.is_at_least_zero()
            && a.is_above_zero()
            && (b.is_at_least_zero() || starts_inside);
        Self { a, b, c, discriminant, is_hit }
    }
}
