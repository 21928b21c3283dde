//! Rays against boxes, by rulings 1 to 5 of `docs/reference/semantics.md`, its sections on conservative boxes and on
//! boxes in fewer bits, and the definition of quantised boxes in `docs/reference/operations.md`.

use super::inputs::{Inputs, Slab};
use super::mistake::Mistake;
use super::number::{Arithmetic, Magnitude, Number, Way};
use raypath_ops::{BoxBits, Rules};
use std::cmp::Ordering;

/// A box in the outcome.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    pub is_hit: bool,
    /// The distance of a hit, and +∞ of a miss.
    pub tmin: Number,
    pub index: usize,
}

impl Entry {
    /// The box of this index, hit or missed at the distance.
    fn new(is_hit: bool, tmin: Number, index: usize) -> Self {
        Self { is_hit, tmin: if is_hit { tmin } else { Number::INFINITY }, index }
    }
}

/// The part of a ray in a box. `None`: every distance is NaN.
struct Interval {
    tmin: Number,
    tmax: Option<Number>,
}

/// The distances of the planes at which a ray enters and leaves the three slabs of a box.
#[derive(Clone, Copy)]
struct Ends {
    near: [Number; 3],
    far: [Number; 3],
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
            let (ends, Interval { tmin, tmax }) = match self.rules {
                Rules::Paper => by_paper(arithmetic, inputs, bounds),
                Rules::Chisel => by_chisel(arithmetic, inputs, bounds),
                Rules::Bounds(BoxBits(bits)) => by_bounds(arithmetic, inputs, bounds, bits),
            };
            let tmin = if self.is_conservative { lowered(arithmetic, inputs, ends, tmin) } else { tmin };
            let is_strict = (self.rules == Rules::Chisel) != arithmetic.makes(Mistake::StrictBoxes);
            let is_right = if is_strict { Ordering::is_lt } else { Ordering::is_le };
            let is_hit = tmax.and_then(|tmax| tmin.order(tmax)).is_some_and(is_right);
            Entry::new(is_hit, if tmin.is_below_zero() { Number::ZERO } else { tmin }, index)
        };
        let entries: Vec<Entry> = inputs.boxes.iter().take(count).enumerate().map(entry).collect();
        match self.rules {
            Rules::Chisel => in_network_order(entries),
            Rules::Paper | Rules::Bounds(_) => nearest_first(arithmetic, entries),
        }
    }
}

/// A conservative box begins earlier, by 32u of the greater distance along kz.
fn lowered(arithmetic: &Arithmetic, inputs: &Inputs, Ends { near, far }: Ends, tmin: Number) -> Number {
    let along_kz = [near, far].map(|ends| ends[inputs.axes[2].min(2)]);
    let magnitude = |number: Number| if number.is_negative() { number.negated() } else { number };
    let numbers = along_kz.map(magnitude).into_iter().filter(|number| !number.is_nan());
    let greatest = numbers.reduce(|a, b| if b.order(a).is_some_and(Ordering::is_gt) { b } else { a });
    arithmetic.sub(tmin, arithmetic.mul(greatest.unwrap_or(Number::Nan), arithmetic.ulps(16)))
}

/// Ruling 5: hits before misses, nearer first, equal distances by index.
fn nearest_first(arithmetic: &Arithmetic, mut entries: Vec<Entry>) -> Vec<Entry> {
    let sign = if arithmetic.makes(Mistake::TiesReversed) { -1 } else { 1 };
    let place = |entry: &Entry| sign * entry.index as i32;
    entries.sort_by(|a, b| {
        let distance = a.tmin.order(b.tmin).unwrap_or(Ordering::Equal);
        b.is_hit.cmp(&a.is_hit).then(distance).then(place(a).cmp(&place(b)))
    });
    entries
}

/// Ruling 1: a ray that runs backwards along an axis enters at the greater bound.
fn ends(arithmetic: &Arithmetic, slabs: [Slab<Number>; 3], backwards: [bool; 3]) -> Ends {
    let is_swapped = backwards.map(|is_backwards| is_backwards && !arithmetic.makes(Mistake::DirectionIgnored));
    let side = |axis: usize, is_far: bool| {
        if is_swapped[axis] != is_far { slabs[axis].max } else { slabs[axis].min }
    };
    Ends { near: [0, 1, 2].map(|axis| side(axis, false)), far: [0, 1, 2].map(|axis| side(axis, true)) }
}

/// Rulings 2 and 3: NaN is ignored, tmin is at least +0.0, and tmax at most the extent.
fn limits(arithmetic: &Arithmetic, Ends { near, far }: Ends, extent: Number) -> Interval {
    let greater = |a: Number, b: Number| if b.order(a).is_some_and(Ordering::is_gt) { b } else { a };
    let less = |a: Number, b: Number| if b.order(a).is_some_and(Ordering::is_lt) { b } else { a };
    let extent = if arithmetic.makes(Mistake::ExtentIgnored) { Number::INFINITY } else { extent };
    let is_number = |number: &Number| !number.is_nan();
    let tmin = near.into_iter().filter(is_number).fold(Number::ZERO, greater);
    Interval { tmin, tmax: far.into_iter().chain([extent]).filter(is_number).reduce(less) }
}

/// The distances of a box's planes.
fn distances(arithmetic: &Arithmetic, inputs: &Inputs, bounds: &[Slab<Number>; 3]) -> [Slab<Number>; 3] {
    std::array::from_fn(|axis| {
        let distance = |bound| arithmetic.mul(arithmetic.sub(bound, inputs.origin[axis]), inputs.inverse[axis]);
        Slab { min: distance(bounds[axis].min), max: distance(bounds[axis].max) }
    })
}

fn by_paper(arithmetic: &Arithmetic, inputs: &Inputs, bounds: &[Slab<Number>; 3]) -> (Ends, Interval) {
    let backwards = inputs.inverse.map(Number::is_negative);
    let ends = ends(arithmetic, distances(arithmetic, inputs, bounds), backwards);
    (ends, limits(arithmetic, ends, inputs.extent))
}

/// The original hardware's rules: sorting networks in which unordered numbers are exchanged.
fn by_chisel(arithmetic: &Arithmetic, inputs: &Inputs, bounds: &[Slab<Number>; 3]) -> (Ends, Interval) {
    let backwards = inputs.direction.map(|direction| !direction.is_at_least_zero());
    let ends = ends(arithmetic, distances(arithmetic, inputs, bounds), backwards);
    let [x, y, z] = ends.near;
    let [tmin, ..] = network([x, y, z, Number::ZERO], |number| *number);
    let [x, y, z] = ends.far;
    let [.., tmax] = network([x, y, z, inputs.extent], |number| *number);
    (ends, Interval { tmin, tmax: Some(tmax) })
}

/// The original's network for four items, the greatest first. Two items keep their order if the first is greater or
/// equal.
fn network<T>(mut items: [T; 4], key: impl Fn(&T) -> Number) -> [T; 4] {
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
        Ok(four) => network(four, |entry| entry.tmin).into_iter().rev().collect(),
        Err(others) => others,
    }
}

/// Boxes in `bits` bits, rounded outwards.
fn by_bounds(arithmetic: &Arithmetic, inputs: &Inputs, bounds: &[Slab<Number>; 3], bits: u32) -> (Ends, Interval) {
    let narrow = |number, way, margin| arithmetic.narrow(number, bits, way, margin);
    let distance = |bound, axis: usize, way| {
        let relative = narrow(arithmetic.sub(bound, inputs.origin[axis]), way, 0);
        narrow(arithmetic.mul(relative, narrow(inputs.inverse[axis], way, 4)), way, 0)
    };
    let [mut near, mut far] = [[Number::Nan; 3]; 2];
    for (axis, Slab { min, max }) in bounds.iter().enumerate() {
        let is_backwards = inputs.inverse[axis].is_negative() && !arithmetic.makes(Mistake::DirectionIgnored);
        let (first, last) = if is_backwards { (*max, *min) } else { (*min, *max) };
        near[axis] = distance(first, axis, Way::TowardZero);
        far[axis] = distance(last, axis, Way::AwayFromZero);
    }
    let ends = Ends { near, far };
    (ends, limits(arithmetic, ends, narrow(inputs.extent, Way::AwayFromZero, 0)))
}

/// Four boxes with bounds of 8 bits.
pub fn quantised(arithmetic: &Arithmetic, inputs: &Inputs) -> Vec<Entry> {
    let is_parallel = inputs.direction.map(Number::is_zero);
    let axes: [[Number; 2]; 3] = std::array::from_fn(|axis| {
        let relative = arithmetic.sub(inputs.node_origin[axis], inputs.origin[axis]);
        let lengths = [relative, inputs.node_scale[axis]];
        // The products are computed, and can raise exceptions, for parallel rays too.
        let products = lengths.map(|length| arithmetic.mul(length, inputs.inverse[axis]));
        if is_parallel[axis] { lengths } else { products }
    });
    let entry = |(index, offsets): (usize, &[Slab<u64>; 3])| {
        let distance = |axis: usize, offset| {
            let [base, step] = axes[axis];
            arithmetic.add(arithmetic.mul(arithmetic.integer(offset), step), base)
        };
        let planes: [Slab<Number>; 3] = std::array::from_fn(|axis| Slab {
            min: distance(axis, offsets[axis].min),
            max: distance(axis, offsets[axis].max),
        });
        let Ends { mut near, mut far } = ends(arithmetic, planes, inputs.inverse.map(Number::is_negative));
        for axis in (0..3).filter(|axis| is_parallel[*axis]) {
            // A slab excludes only rays outside of it: its planes are then relative to the ray.
            near[axis] = Number::Signed(!planes[axis].min.is_above_zero(), Magnitude::Infinite);
            far[axis] = Number::Signed(planes[axis].max.is_below_zero(), Magnitude::Infinite);
        }
        let Interval { tmin, tmax } = limits(arithmetic, Ends { near, far }, inputs.extent);
        let is_used = inputs.used >> index & 1 == 1 || arithmetic.makes(Mistake::UnusedChildren);
        let is_hit = is_used && tmax.and_then(|tmax| tmin.order(tmax)).is_some_and(Ordering::is_le);
        Entry::new(is_hit, tmin, index)
    };
    nearest_first(arithmetic, inputs.offsets.iter().enumerate().map(entry).collect())
}
