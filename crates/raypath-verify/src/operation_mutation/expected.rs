//! The outcomes of the paper's operations by the text of `docs/reference/semantics.md`, in binary64 arithmetic rounded
//! once: with any number of lanes and accumulators, all features of triangles, and all rules of boxes but `chisel`.

use crate::oracle::{TriangleSteps, add, mul, sub};
use raypath_ops::operations::quantised_box::QuantisedNode;
use raypath_ops::{
    Aabb, Beat, Binary32, Culling, Edges, Num, Ray, RayTriangleExtended, RayTriangleExtendedInput,
    RayTriangleExtendedOutput, RayTriangleInput, Rounding, Rules, Triangle,
};

/// How the interval of a ray in a box is computed.
#[derive(Debug, Clone, Copy)]
pub enum Boxes {
    /// Every operator rounds to nearest.
    Nearest,
    /// tmax is multiplied by 1 + 3 units in the last place.
    Widened,
    /// Distances of so many bits, rounded outwards.
    Bits(u32),
}

/// A box in the order of hits: whether it is hit, its distance, and its index.
pub type Entry = (bool, f32, u32);

/// Rulings 1 to 5: the boxes in order.
pub fn boxes<const N: usize>(ray: &Ray<Binary32>, aabb: &[Aabb<Binary32>; N], how: Boxes) -> [Entry; N] {
    let origin: [f32; 3] = ray.origin.into();
    let inv: [f32; 3] = ray.inv.into();
    let extent = f32::from(ray.extent);
    let mut entries: [Entry; N] = std::array::from_fn(|index| {
        let (mut nears, mut fars) = (Vec::new(), vec![extent]);
        if let Boxes::Bits(bits) = how {
            fars[0] = outwards(extent, bits, 0);
        }
        let slabs = [aabb[index].x, aabb[index].y, aabb[index].z];
        for (slab, (origin, inv)) in slabs.into_iter().zip(origin.into_iter().zip(inv)) {
            let [mut near, mut far]: [f32; 2] = [slab.min.into(), slab.max.into()];
            if inv.is_sign_negative() {
                (near, far) = (far, near);
            }
            let differences = [sub(near, origin), sub(far, origin)];
            let [near, far] = match how {
                Boxes::Nearest | Boxes::Widened => differences.map(|difference| mul(difference, inv)),
                Boxes::Bits(bits) => [
                    inwards(mul(inwards(differences[0], bits, 0), inwards(inv, bits, 4)), bits, 0),
                    outwards(mul(outwards(differences[1], bits, 0), outwards(inv, bits, 4)), bits, 0),
                ],
            };
            nears.push(near);
            fars.push(far);
        }
        let greatest = nears.into_iter().filter(|near| *near > 0.0).fold(0.0, f32::max);
        let least = fars.into_iter().filter(|far| !far.is_nan()).reduce(f32::min).unwrap_or(f32::NAN);
        let least = match how {
            Boxes::Widened => mul(least, f32::from_bits(1.0_f32.to_bits() + 3)),
            Boxes::Nearest | Boxes::Bits(_) => least,
        };
        let hit = greatest <= least;
        (hit, if hit { greatest } else { f32::INFINITY }, index as u32)
    });
    entries.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    entries
}

/// The boxes of a quantised node in order, by the text of [`QuantisedBox`](raypath_ops::operations::quantised_box): a
/// plane has the distance `(origin - ray.origin) · inv + offset · (scale · inv)`. Along an axis in which the direction
/// is zero, a slab excludes only rays outside it, and its planes are those relative to the origin of the ray.
pub fn quantised(ray: &Ray<Binary32>, node: &QuantisedNode<Binary32>) -> [Entry; 4] {
    let [from, dir, inv]: [[f32; 3]; 3] = [ray.origin, ray.dir, ray.inv].map(Into::into);
    let [origin, scale]: [[f32; 3]; 2] = [node.origin, node.scale].map(Into::into);
    let mut entries: [Entry; 4] = std::array::from_fn(|index| {
        let child = node.child[index];
        let (mut greatest, mut least) = (0.0_f32, f32::from(ray.extent));
        for (axis, slab) in [child.x, child.y, child.z].into_iter().enumerate() {
            let is_parallel = dir[axis] == 0.0;
            let times = |number: f32| if is_parallel { number } else { mul(number, inv[axis]) };
            let (base, step) = (times(sub(origin[axis], from[axis])), times(scale[axis]));
            let [min, max] = [slab.min, slab.max].map(|offset| add(mul(u32::from(offset) as f32, step), base));
            let is_beside = is_parallel && (min > 0.0 || max < 0.0);
            if is_beside {
                (greatest, least) = if min > 0.0 { (f32::INFINITY, least) } else { (greatest, f32::NEG_INFINITY) };
            } else if !is_parallel {
                let (near, far) = if inv[axis].is_sign_negative() { (max, min) } else { (min, max) };
                greatest = if near > greatest { near } else { greatest };
                least = if far < least || least.is_nan() { far } else { least };
            }
        }
        let hit = bool::from(node.used.0[index]) && greatest <= least;
        (hit, if hit { greatest } else { f32::INFINITY }, index as u32)
    });
    entries.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    entries
}

/// T of the rules `bounds`: the magnitude less the margin, rounded toward zero.
fn inwards(number: f32, bits: u32, margin: u32) -> f32 {
    narrowed(
        number,
        bits,
        (0..margin).fold(number.abs(), |moved, _| if moved > 0.0 { moved.next_down() } else { moved }),
        f64::floor,
    )
}

/// A: the magnitude and the margin, rounded away from zero.
fn outwards(number: f32, bits: u32, margin: u32) -> f32 {
    narrowed(number, bits, (0..margin).fold(number.abs(), |moved, _| moved.next_up()), f64::ceil)
}

fn narrowed(number: f32, bits: u32, moved: f32, round: fn(f64) -> f64) -> f32 {
    if !number.is_finite() {
        return number;
    }
    // A power of two that divides all numbers of so many bits near this one. The exponent of binary64 has no limit
    // here.
    let exponent = (f64::from(moved).to_bits() >> 52) as i32 - 1023;
    let unit = 2.0_f64.powi(exponent + 1 - bits as i32);
    let rounded = if moved == 0.0 { 0.0 } else { round(f64::from(moved) / unit) * unit };
    let kept = if rounded < 2.0_f64.powi(-125) { 0.0 } else { rounded };
    (kept as f32).copysign(number)
}

/// A sum that rounds once.
fn sum_once(terms: &[f32]) -> f32 {
    match *terms {
        [term] => return term,
        [a, b] => return add(a, b),
        _ => {}
    }
    let infinities: Vec<f32> = terms.iter().copied().filter(|term| term.is_infinite()).collect();
    if terms.iter().any(|term| term.is_nan()) || infinities.windows(2).any(|pair| pair[0] != pair[1]) {
        return f32::NAN;
    }
    if let Some(&infinity) = infinities.first() {
        return infinity;
    }
    if terms.iter().all(|term| *term == 0.0) {
        return if terms.iter().all(|term| term.is_sign_negative()) { -0.0 } else { 0.0 };
    }
    let greatest = terms.iter().map(|term| f64::from(term.abs())).fold(0.0, f64::max);
    let exponent = (greatest.to_bits() >> 52) as i32 - 1023;
    let window = 24 + (terms.len() as f64).log2().ceil() as i32;
    let last = 2.0_f64.powi(exponent - window + 1);
    // At most 64 terms of 30 bits: exact in binary64.
    let total: f64 = terms.iter().map(|term| (f64::from(*term) / last).trunc()).sum();
    // Zero is +0; a sum of integers in binary64 is never −0 unless all are.
    if total == 0.0 { 0.0 } else { (total * last) as f32 }
}

/// Lane i and lane i + n/2, until one is left.
fn halved(mut lanes: Vec<f32>) -> f32 {
    while lanes.len() > 1 {
        let upper = lanes.split_off(lanes.len() / 2);
        lanes.iter_mut().zip(upper).for_each(|(lane, other)| *lane = add(*lane, other));
    }
    lanes.first().copied().unwrap_or(0.0)
}

/// The sum of a beat's squared differences.
pub fn squares<const N: usize>(beat: &Beat<Binary32, N>, rounding: Rounding) -> f32 {
    let lane = |i: usize| if bool::from(beat.mask.0[i]) { sub(beat.a[i].into(), beat.b[i].into()) } else { 0.0 };
    let squares: Vec<f32> = (0..N).map(|i| mul(lane(i), lane(i))).collect();
    match rounding {
        Rounding::Unit => halved(squares),
        Rounding::Sum => add(sum_once(&squares[..N / 2]), sum_once(&squares[N / 2..])),
    }
}

/// The sums of a beat's products a·b and b·b.
pub fn products<const N: usize>(beat: &Beat<Binary32, N>, rounding: Rounding) -> [f32; 2] {
    let lane = |of: &[Num<Binary32>; N], i: usize| if bool::from(beat.mask.0[i]) { of[i].into() } else { 0.0 };
    [&beat.a, &beat.b].map(|other| {
        let products: Vec<f32> = (0..N).map(|i| mul(lane(other, i), lane(&beat.b, i))).collect();
        if rounding == Rounding::Unit { halved(products) } else { sum_once(&products) }
    })
}

/// The triangle test, with features and either rule set.
pub fn triangle(
    options: &RayTriangleExtended,
    job: &RayTriangleExtendedInput<Binary32>,
) -> RayTriangleExtendedOutput<Binary32> {
    let RayTriangleExtendedInput { ray, triangle, t_min } = *job;
    let mut met = TriangleSteps::of(&RayTriangleInput { ray, triangle });
    if options.rounding == Rounding::Sum {
        met.t_denom = sum_once(&[met.u, met.v, met.w]);
        let depths = depths(&ray, &triangle);
        met.t_num = sum_once(&[mul(met.u, depths[0]), mul(met.v, depths[1]), mul(met.w, depths[2])]);
    }
    let mirrored = TriangleSteps { u: -met.u, v: -met.v, w: -met.w, t_num: -met.t_num, ..met };
    let ends = [f32::from(t_min), f32::from(ray.extent)].map(|end| mul(end, met.t_denom));
    let is_chisel = options.rules == Rules::Chisel;
    // Comparisons show a hit by `paper`, and no miss by `chisel`.
    let at_most = |a: f32, b: f32| a <= b || is_chisel && (a.is_nan() || b.is_nan());
    let is_hit = |seen: TriangleSteps| if is_chisel { seen.hit_by_chisel() } else { seen.hit_by_paper() };
    let front = is_hit(met) && (!options.range || at_most(ends[0], met.t_num) && at_most(met.t_num, ends[1]));
    let back = is_hit(mirrored) && (!options.range || at_most(met.t_num, ends[0]) && at_most(ends[1], met.t_num));
    let hit = match options.culling {
        Culling::Back => front,
        Culling::Front => back,
        Culling::None => front || back,
    };
    RayTriangleExtendedOutput {
        t_num: met.t_num.into(),
        t_denom: met.t_denom.into(),
        triangle_hit: hit.into(),
        barycentric: Edges { u: met.u.into(), v: met.v.into(), w: met.w.into() },
        facing: (met.t_denom > 0.0).into(),
    }
}

/// Sz times the coordinate of each vertex along kz.
fn depths(ray: &Ray<Binary32>, triangle: &Triangle<Binary32>) -> [f32; 3] {
    let axis = (u32::from(ray.kz) as usize).min(2);
    let along = |point: [f32; 3]| point[axis];
    [triangle.a, triangle.b, triangle.c]
        .map(|vertex| mul(ray.shear.z.into(), sub(along(vertex.into()), along(ray.origin.into()))))
}
