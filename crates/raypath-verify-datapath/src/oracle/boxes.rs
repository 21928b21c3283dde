//! Rays against boxes, by rulings 1 to 5 of `docs/reference/semantics.md`, its sections on conservative boxes and on
//! boxes in fewer bits, and the definition of quantised boxes in `docs/reference/operations.md`.

use super::inputs::{Inputs, Slab};
use super::mistake::Mistake;
use super::number::{Arithmetic, Number, Outward};
use raypath_ops::{BoxBits, Rules};
use std::cmp::Ordering;

/// A box in the outcome.
#[derive(Debug, Clone)]
pub struct Entry {
    pub is_hit: bool,
    /// The distance of a hit, and +∞ of a miss.
    pub tmin: Number,
    pub index: usize,
}

/// The part of a ray in a box. `None`: every distance is NaN.
struct Interval {
    tmin: Number,
    tmax: Option<Number>,
}

/// A test of boxes of numbers.
#[derive(Debug, Clone, Copy)]
pub struct Slabs {
    pub rules: Rules,
    pub is_conservative: bool,
}

impl Slabs {
    pub const PAPER: Self = Self { rules: Rules::Paper, is_conservative: false };

    /// The boxes in the order of the outcome.
    pub fn answer(self, arithmetic: &Arithmetic, inputs: &Inputs, count: usize) -> Vec<Entry> {
        let entry = |(index, bounds): (usize, &[Slab<Number>; 3])| {
            let Interval { tmin, tmax } = match self.rules {
                Rules::Paper => by_paper(arithmetic, inputs, bounds),
                Rules::Chisel => by_chisel(arithmetic, inputs, bounds),
                Rules::Bounds(BoxBits(bits)) => by_bounds(arithmetic, inputs, bounds, bits),
            };
            let tmax = tmax.map(|tmax| match self.is_conservative {
                true => arithmetic.mul(&tmax, &arithmetic.one_plus_ulps(3)),
                false => tmax,
            });
            let order = tmax.and_then(|tmax| tmin.order(&tmax));
            let is_strict = (self.rules == Rules::Chisel) != arithmetic.makes(Mistake::StrictBoxes);
            let is_hit = order.is_some_and(if is_strict { Ordering::is_lt } else { Ordering::is_le });
            Entry { is_hit, tmin: if is_hit { tmin } else { Number::INFINITY }, index }
        };
        let entries: Vec<Entry> = inputs.boxes.iter().take(count).enumerate().map(entry).collect();
        match self.rules {
            Rules::Chisel => in_network_order(entries),
            Rules::Paper | Rules::Bounds(_) => nearest_first(arithmetic, entries),
        }
    }
}

/// Ruling 5: hits before misses, nearer first, equal distances by index.
fn nearest_first(arithmetic: &Arithmetic, mut entries: Vec<Entry>) -> Vec<Entry> {
    let sign = if arithmetic.makes(Mistake::TiesReversed) { -1 } else { 1 };
    let place = |entry: &Entry| sign * entry.index as i32;
    entries.sort_by(|a, b| {
        let distance = a.tmin.order(&b.tmin).unwrap_or(Ordering::Equal);
        b.is_hit.cmp(&a.is_hit).then(distance).then(place(a).cmp(&place(b)))
    });
    entries
}

/// Both ends of the slabs along the ray, near and far, by ruling 1.
fn ends(arithmetic: &Arithmetic, slabs: [Slab<Number>; 3], backwards: [bool; 3]) -> ([Number; 3], [Number; 3]) {
    let is_ignored = arithmetic.makes(Mistake::DirectionIgnored);
    let mut pairs = slabs
        .into_iter()
        .zip(backwards)
        .map(|(Slab { min, max }, is_backwards)| if is_backwards && !is_ignored { (max, min) } else { (min, max) });
    let mut next = || pairs.next().unwrap_or((Number::Nan, Number::Nan));
    let [(x, fx), (y, fy), (z, fz)] = [next(), next(), next()];
    ([x, y, z], [fx, fy, fz])
}

/// Rulings 2 and 3: NaN is ignored, tmin is at least +0.0, and tmax at most the extent.
fn limits(arithmetic: &Arithmetic, near: [Number; 3], far: [Number; 3], extent: &Number) -> Interval {
    let greater = |a: Number, b: Number| if b.order(&a).is_some_and(Ordering::is_gt) { b } else { a };
    let less = |a: Number, b: Number| if b.order(&a).is_some_and(Ordering::is_lt) { b } else { a };
    let extent = if arithmetic.makes(Mistake::ExtentIgnored) { Number::INFINITY } else { extent.clone() };
    let tmin = near.into_iter().filter(|number| !number.is_nan()).fold(Number::ZERO, greater);
    let tmax = far.into_iter().chain([extent]).filter(|number| !number.is_nan()).reduce(less);
    Interval { tmin, tmax }
}

/// The distances of a box's planes.
fn distances(arithmetic: &Arithmetic, inputs: &Inputs, bounds: &[Slab<Number>; 3]) -> [Slab<Number>; 3] {
    std::array::from_fn(|axis| {
        let distance = |bound| arithmetic.mul(&arithmetic.sub(bound, &inputs.origin[axis]), &inputs.inverse[axis]);
        Slab { min: distance(&bounds[axis].min), max: distance(&bounds[axis].max) }
    })
}

fn by_paper(arithmetic: &Arithmetic, inputs: &Inputs, bounds: &[Slab<Number>; 3]) -> Interval {
    let backwards = std::array::from_fn(|axis| inputs.inverse[axis].is_negative());
    let (near, far) = ends(arithmetic, distances(arithmetic, inputs, bounds), backwards);
    limits(arithmetic, near, far, &inputs.extent)
}

/// The original hardware's rules: sorting networks in which unordered numbers are exchanged.
fn by_chisel(arithmetic: &Arithmetic, inputs: &Inputs, bounds: &[Slab<Number>; 3]) -> Interval {
    let backwards = std::array::from_fn(|axis| !inputs.direction[axis].is_at_least_zero());
    let (near, far) = ends(arithmetic, distances(arithmetic, inputs, bounds), backwards);
    let [x, y, z] = near;
    let [tmin, ..] = network([x, y, z, Number::ZERO], |number| number);
    let [x, y, z] = far;
    let [.., tmax] = network([x, y, z, inputs.extent.clone()], |number| number);
    Interval { tmin, tmax: Some(tmax) }
}

/// The original's network for four items, the greatest first. Two items keep their order if the first is greater or
/// equal.
fn network<T>(mut items: [T; 4], key: impl Fn(&T) -> &Number) -> [T; 4] {
    for (i, j) in [(0, 2), (1, 3), (0, 1), (2, 3), (1, 2)] {
        if !key(&items[i]).order(key(&items[j])).is_some_and(Ordering::is_ge) {
            items.swap(i, j);
        }
    }
    items
}

/// The original's order: its network on the distances, then reversed.
fn in_network_order(entries: Vec<Entry>) -> Vec<Entry> {
    match <[Entry; 4]>::try_from(entries) {
        Ok(four) => network(four, |entry| &entry.tmin).into_iter().rev().collect(),
        Err(others) => others,
    }
}

/// Boxes in `bits` bits, rounded outwards.
fn by_bounds(arithmetic: &Arithmetic, inputs: &Inputs, bounds: &[Slab<Number>; 3], bits: u32) -> Interval {
    let way = |way, margin| move |number: &Number| arithmetic.narrow(number, bits, way, margin);
    let (toward, away) = (way(Outward::TowardZero, 0), way(Outward::AwayFromZero, 0));
    let (toward_by_4, away_by_4) = (way(Outward::TowardZero, 4), way(Outward::AwayFromZero, 4));
    let mut near = Vec::new();
    let mut far = Vec::new();
    for (axis, Slab { min, max }) in bounds.iter().enumerate() {
        let (inverse, origin) = (&inputs.inverse[axis], &inputs.origin[axis]);
        let (first, last) = if inverse.is_negative() { (max, min) } else { (min, max) };
        let relative = |bound| arithmetic.sub(bound, origin);
        near.push(toward(&arithmetic.mul(&toward(&relative(first)), &toward_by_4(inverse))));
        far.push(away(&arithmetic.mul(&away(&relative(last)), &away_by_4(inverse))));
    }
    let three = |ends: Vec<Number>| <[Number; 3]>::try_from(ends).unwrap_or([Number::Nan, Number::Nan, Number::Nan]);
    limits(arithmetic, three(near), three(far), &away(&inputs.extent))
}

/// Four boxes with bounds of 8 bits.
pub fn quantised(arithmetic: &Arithmetic, inputs: &Inputs) -> Vec<Entry> {
    struct Axis {
        is_parallel: bool,
        is_backwards: bool,
        base: Number,
        step: Number,
    }
    let axes: [Axis; 3] = std::array::from_fn(|axis| {
        let inverse = &inputs.inverse[axis];
        let relative = arithmetic.sub(&inputs.node_origin[axis], &inputs.origin[axis]);
        let scale = &inputs.node_scale[axis];
        // The products are computed, and can raise exceptions, for parallel rays too.
        let (base, step) = (arithmetic.mul(&relative, inverse), arithmetic.mul(scale, inverse));
        let is_parallel = inputs.direction[axis].is_zero();
        let (base, step) = if is_parallel { (relative, scale.clone()) } else { (base, step) };
        Axis { is_parallel, is_backwards: inverse.is_negative(), base, step }
    });
    let entry = |(index, offsets): (usize, &[Slab<u64>; 3])| {
        let mut near = [Number::Nan, Number::Nan, Number::Nan];
        let mut far = near.clone();
        for (k, Axis { is_parallel, is_backwards, base, step }) in axes.iter().enumerate() {
            let distance = |offset| arithmetic.add(&arithmetic.mul(&arithmetic.integer(offset), step), base);
            let (min, max) = (distance(offsets[k].min), distance(offsets[k].max));
            (near[k], far[k]) = match (is_parallel, is_backwards) {
                // A slab excludes only rays outside of it: `min` and `max` are then relative to the ray.
                (true, _) => (Number::Infinite(!min.is_above_zero()), Number::Infinite(max.is_below_zero())),
                (false, true) => (max, min),
                (false, false) => (min, max),
            };
        }
        let Interval { tmin, tmax } = limits(arithmetic, near, far, &inputs.extent);
        let is_used = inputs.used >> index & 1 == 1 || arithmetic.makes(Mistake::UnusedChildren);
        let is_hit = is_used && tmax.and_then(|tmax| tmin.order(&tmax)).is_some_and(Ordering::is_le);
        Entry { is_hit, tmin: if is_hit { tmin } else { Number::INFINITY }, index }
    };
    nearest_first(arithmetic, inputs.offsets.iter().enumerate().map(entry).collect())
}
