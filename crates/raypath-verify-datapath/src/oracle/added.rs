//! The added operations that test no boxes against rays, by their definitions in `docs/reference/operations.md`.

use super::inputs::{Inputs, Slab};
use super::mistake::Mistake;
use super::number::{Arithmetic, Number};
use std::cmp::Ordering;

/// The child of a key: that of the separators that are not greater than it. In an ascending list, those come first.
pub fn child(arithmetic: &Arithmetic, inputs: &Inputs) -> u64 {
    let is_strict = arithmetic.makes(Mistake::StrictKeys);
    let reached: Vec<bool> = inputs
        .separators
        .iter()
        .map(|separator| {
            separator.order(&inputs.key).is_some_and(if is_strict { Ordering::is_lt } else { Ordering::is_le })
        })
        .collect();
    by_bisection(&reached)
}

/// The index that bisection finds: for separators out of order it differs from the count, and is defined by its steps.
fn by_bisection(reached: &[bool]) -> u64 {
    let (mut first, mut step) = (0, 32);
    while step > 0 {
        if reached.get(first + step - 1).copied().unwrap_or(false) {
            first += step;
        }
        step /= 2;
    }
    first as u64
}

/// The boxes that contain the point, bit i for box i.
pub fn inside(arithmetic: &Arithmetic, inputs: &Inputs) -> u64 {
    let is_open = arithmetic.makes(Mistake::OpenPoints);
    let is_in = |order: Option<Ordering>| order.is_some_and(if is_open { Ordering::is_lt } else { Ordering::is_le });
    let is_inside = |bounds: &[Slab<Number>; 3]| {
        bounds.iter().zip(&inputs.point).all(|(Slab { min, max }, x)| is_in(min.order(x)) && is_in(x.order(max)))
    };
    inputs.boxes.iter().rev().fold(0, |mask, bounds| mask << 1 | u64::from(is_inside(bounds)))
}

/// The quadratic equation of a ray and a sphere.
pub struct Sphere {
    pub a: Number,
    pub b: Number,
    pub c: Number,
    pub discriminant: Number,
    pub is_hit: bool,
}

impl Sphere {
    pub fn of(arithmetic: &Arithmetic, inputs: &Inputs) -> Self {
        let (add, sub, mul) = (
            |x: &_, y: &_| arithmetic.add(x, y),
            |x: &_, y: &_| arithmetic.sub(x, y),
            |x: &_, y: &_| arithmetic.mul(x, y),
        );
        let dot = |x: &[Number; 3], y: &[Number; 3]| {
            let [p, q, r] = std::array::from_fn(|axis| mul(&x[axis], &y[axis]));
            add(&add(&p, &q), &r)
        };
        let d = &inputs.direction;
        let f: [Number; 3] = std::array::from_fn(|axis| sub(&inputs.centre[axis], &inputs.origin[axis]));
        let normal = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| sub(&mul(&f[i], &d[j]), &mul(&f[j], &d[i])));
        let square = mul(&inputs.radius, &inputs.radius);
        let (a, b) = (dot(d, d), dot(&f, d));
        let c = sub(&dot(&f, &f), &square);
        let discriminant = sub(&mul(&square, &a), &dot(&normal, &normal));
        let is_any_nan = [&a, &b, &c, &discriminant].into_iter().any(Number::is_nan);
        let starts_inside = !c.is_above_zero() || arithmetic.makes(Mistake::SpheresBehind);
        let is_hit = !is_any_nan
            && discriminant.is_at_least_zero()
            && a.is_above_zero()
            && (b.is_at_least_zero() || starts_inside);
        Self { a, b, c, discriminant, is_hit }
    }
}
