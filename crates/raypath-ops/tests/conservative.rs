//! The conservative box test, compared with exact arithmetic: a box that a ray touches is never missed.

use num_rational::BigRational;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_ops::{Aabb, Binary32, Operation, Ray, RayBox, RayBoxConservative, RayBoxInput, RayBoxOutput, Rules};

/// A ray and a box.
#[derive(Debug, Clone, Copy)]
struct Case {
    origin: [f32; 3],
    direction: [f32; 3],
    extent: f32,
    min: [f32; 3],
    max: [f32; 3],
}

fn exact(number: f32) -> BigRational {
    BigRational::from_float(number).expect("a finite number")
}

impl Case {
    /// The exact interval in which the ray is inside all slabs and between its ends.
    fn interval(&self) -> Option<[BigRational; 2]> {
        let mut from = exact(0.0);
        let mut to = self.extent.is_finite().then(|| exact(self.extent));
        for axis in 0..3 {
            let [origin, min, max] = [self.origin, self.min, self.max].map(|of| exact(of[axis]));
            let direction = exact(self.direction[axis]);
            if self.direction[axis] == 0.0 {
                if origin < min || origin > max {
                    return None;
                }
                continue;
            }
            let [one, other] = [min, max].map(|bound| (bound - &origin) / &direction);
            let (near, far) = if one < other { (one, other) } else { (other, one) };
            from = from.max(near);
            to = Some(to.map_or(far.clone(), |to| to.min(far)));
        }
        Some([from, to.expect("a direction")])
    }

    fn is_touched(&self) -> bool {
        self.interval().is_some_and(|[from, to]| from <= to)
    }

    /// The results of the plain and of the conservative operation.
    fn hits(&self) -> (bool, bool) {
        let ray = Ray::new(self.origin, self.direction, self.extent).expect("a ray");
        let job = RayBoxInput { ray, aabb: [Aabb::new(self.min, self.max); 4] };
        let all = |output: RayBoxOutput<Binary32>| {
            let hits = output.is_intersect.to_array();
            assert!(hits == [hits[0]; 4]);
            hits[0]
        };
        let plain = RayBox { rules: Rules::Paper }.run(Binary32, job, ()).0;
        (all(plain), all(RayBoxConservative.run(Binary32, job, ()).0))
    }
}

/// The number of touched boxes, and how many of them the plain operation misses. Checks that the conservative operation
/// misses none.
fn touched_and_missed(cases: impl Iterator<Item = Case>) -> [usize; 2] {
    let mut touched = 0;
    let mut missed = 0;
    for case in cases {
        let (plain, conservative) = case.hits();
        if case.is_touched() {
            touched += 1;
            assert!(conservative, "{case:?} is touched and missed");
            missed += usize::from(!plain);
        } else if conservative {
            // A box that is hit without being touched is almost touched.
            let almost = case.interval().is_some_and(|[from, to]| from <= to * exact(1.0 + 2.0 * f32::powi(2.0, -20)));
            assert!(almost, "{case:?} is far from touched and hit");
        }
        assert!(conservative || !plain, "{case:?} is hit by the plain operation only");
    }
    [touched, missed]
}

fn next_to(number: f32, places: i32) -> f32 {
    f32::from_bits(number.to_bits().wrapping_add_signed(places))
}

/// Rays that leave one slab near the point at which they enter another, at an edge, or at a corner with the third axis.
/// Boxes that share faces surround the edge or corner.
fn at_edges(rng: &mut ChaCha8Rng, corner: bool) -> Vec<Case> {
    let origin: [f32; 3] = std::array::from_fn(|_| rng.random_range(-8.0..8.0));
    let edge: [f32; 3] = std::array::from_fn(|axis| {
        let away: f32 = rng.random_range(0.01..64.0);
        origin[axis] + if rng.random() { away } else { -away }
    });
    let way: [f64; 3] = std::array::from_fn(|axis| f64::from(edge[axis]) - f64::from(origin[axis]));
    let speed: f64 = rng.random_range(0.01..10.0);
    let direction: [f32; 3] = way.map(|way| next_to((way * speed) as f32, rng.random_range(-1..=1)));
    let quadrants = if corner { 8 } else { 4 };
    let boxes = (0..quadrants).map(|quadrant| {
        let (mut min, mut max) = (edge, edge);
        for axis in 0..3 {
            if !corner && axis == 2 {
                (min[axis], max[axis]) = (-1e4, 1e4);
            } else if quadrant >> axis & 1 == 1 {
                max[axis] += 5.0;
            } else {
                min[axis] -= 5.0;
            }
        }
        Case { origin, direction, extent: f32::INFINITY, min, max }
    });
    boxes.collect()
}

#[test]
fn edges_and_corners_are_not_missed() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for corner in [false, true] {
        let cases: Vec<Case> = (0..6_000).flat_map(|_| at_edges(&mut rng, corner)).collect();
        let [touched, missed] = touched_and_missed(cases.into_iter());
        assert!(touched > 3_000 && missed > 50, "{touched} touched, {missed} of them missed without the feature");
    }
}

/// A ray in the plane of the face that two boxes share hits both, and so does a ray that ends in the face.
#[test]
fn shared_faces_are_not_missed() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut cases = Vec::new();
    for _ in 0..5_000 {
        let face: f32 = rng.random_range(-9.0..9.0);
        let origin: [f32; 3] = std::array::from_fn(|_| rng.random_range(-9.0..9.0));
        let direction: [f32; 3] = std::array::from_fn(|_| rng.random_range(-2.0..2.0));
        let (below, above) = ([face - 3.0, -99.0, -99.0], [face + 3.0, 99.0, 99.0]);
        let zero = if rng.random() { 0.0 } else { -0.0 };
        let along = Case {
            origin: [face, origin[1], origin[2]],
            direction: [zero, direction[1], direction[2]],
            extent: f32::INFINITY,
            min: below,
            max: [face, 99.0, 99.0],
        };
        cases.extend([along, Case { min: [face, -99.0, -99.0], max: above, ..along }]);
        // The ray ends near the point at which it meets the face.
        let distance = ((f64::from(face) - f64::from(origin[0])) / f64::from(direction[0])) as f32;
        if distance > 0.0 {
            let extent = next_to(distance, rng.random_range(-1..=1));
            let max = if direction[0] > 0.0 { above } else { [face, 99.0, 99.0] };
            let min = if direction[0] > 0.0 { [face, -99.0, -99.0] } else { below };
            cases.push(Case { origin, direction, extent, min, max });
        }
    }
    let [touched, missed] = touched_and_missed(cases.into_iter());
    assert!(touched > 10_000 && missed > 10, "{touched} touched, {missed} of them missed without the feature");
}

/// A slab distance with three roundings in the same direction, near their maximum.
#[derive(Clone, Copy)]
struct Worst {
    bound: f32,
    direction: f32,
    exact: f64,
}

/// Bounds whose computed distance is too small or too large. The difference from `origin` loses the origin.
fn worst(rng: &mut ChaCha8Rng, origin: f32, too_large: bool) -> Vec<Worst> {
    let ulp = f64::from(f32::EPSILON);
    let candidates = (0..4_000_000).filter_map(|_| {
        let bound = 1.0 + rng.random_range(0..1_u32 << 19) as f32 * f32::EPSILON;
        let direction: f32 = bound / rng.random_range(1.2_f32..1.245);
        let exact = (f64::from(bound) - f64::from(origin)) / f64::from(direction);
        let computed = f64::from((bound - origin) * (1.0 / direction));
        let error = if too_large { computed - exact } else { exact - computed };
        (error > 1.5 * ulp).then_some(Worst { bound, direction, exact })
    });
    let mut worst: Vec<Worst> = candidates.collect();
    worst.sort_by(|a, b| a.exact.total_cmp(&b.exact));
    worst
}

/// Compared with the exact direction instead of its rounded inverse, a factor of 1 + 2 ulps (1.00000024) is not enough.
#[test]
fn the_worst_roundings_need_three_units() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let lost = 15.0 * f32::powi(2.0, -28);
    let (left, entered) = (worst(&mut rng, -lost, false), worst(&mut rng, lost, true));
    let mut missed = [0; 4];
    for x in left {
        // The last slab that is entered before x is left.
        let Some(y) = entered.partition_point(|y| y.exact <= x.exact).checked_sub(1).map(|at| entered[at]) else {
            continue;
        };
        let case = Case {
            origin: [-lost, lost, 0.0],
            direction: [x.direction, y.direction, 0.25],
            extent: f32::INFINITY,
            min: [x.bound - 4.0, y.bound, -99.0],
            max: [x.bound, y.bound + 4.0, 99.0],
        };
        assert!(case.is_touched());
        let (plain, conservative) = case.hits();
        assert!(conservative, "{case:?}");
        let tmax = (x.bound + lost) * (1.0 / x.direction);
        let tmin = (y.bound - lost) * (1.0 / y.direction);
        for (ulps, missed) in missed.iter_mut().enumerate() {
            *missed += usize::from(tmin > tmax * (1.0 + ulps as f32 * f32::EPSILON));
        }
        assert_eq!(plain, tmin <= tmax);
    }
    assert!(missed[0] > 0 && missed[2] > 0, "{missed:?}");
    assert_eq!(missed[3], 0);
}
