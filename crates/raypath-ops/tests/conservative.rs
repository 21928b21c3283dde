//! The conservative box test, compared with exact arithmetic: a box that a ray touches is never missed; and with the
//! triangle test: neither is a box around a triangle that is hit.

use num_rational::BigRational;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_ops::{
    Aabb, Binary32, Culling, Operation, Ray, RayBox, RayBoxInput, RayBoxOutput, RayTriangleExtended,
    RayTriangleExtendedInput, Rules, Triangle,
};

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

    /// The greater distance at which the ray is in a plane of the slab along its longest axis.
    fn depth(&self) -> BigRational {
        let longest = |a: &usize, b: &usize| self.direction[*a].abs().total_cmp(&self.direction[*b].abs());
        let axis = (0..3).max_by(longest).expect("three axes");
        let distance = |bound: f32| (exact(bound) - exact(self.origin[axis])) / exact(self.direction[axis]);
        let magnitude = |x: BigRational| if x < exact(0.0) { -x } else { x };
        [self.min, self.max].map(|bound| magnitude(distance(bound[axis]))).into_iter().max().expect("two bounds")
    }

    fn is_touched(&self) -> bool {
        self.interval().is_some_and(|[from, to]| from <= to)
    }

    /// Whether the box is hit if tmax is increased by 3 ulps, which is enough for the exact ray and any box.
    fn is_hit_with_a_factor(&self) -> bool {
        let (mut tmin, mut tmax) = (0.0_f32, self.extent);
        for axis in 0..3 {
            let inverse = 1.0 / self.direction[axis];
            let ends = [self.min, self.max].map(|bound| (bound[axis] - self.origin[axis]) * inverse);
            (tmin, tmax) = (tmin.max(ends[0].min(ends[1])), tmax.min(ends[0].max(ends[1])));
        }
        tmin <= tmax * (1.0 + 3.0 * f32::EPSILON)
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
        let [plain, conservative] = [false, true]
            .map(|is_conservative| RayBox { rules: Rules::Paper, is_conservative }.run(Binary32, job, ()).0);
        (all(plain), all(conservative))
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
            let margin = exact(f32::powi(2.0, -18)) * case.depth();
            let almost = case.interval().is_some_and(|[from, to]| from <= to + margin);
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

/// Triangles with an edge along the longest axis of rays that pass close to it, in front of the origin and around it. The
/// x and y of the edge are bounds of the box.
#[test]
fn boxes_around_hit_triangles_are_not_missed() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let triangles = RayTriangleExtended { culling: Culling::None, ..RayTriangleExtended::PLAIN };
    let (mut hits, mut without, mut by_a_factor) = (0, 0, 0);
    for _ in 0..300_000 {
        let [x, y]: [f32; 2] = std::array::from_fn(|_| rng.random_range(-4.0..4.0));
        let ends: [f32; 2] = std::array::from_fn(|_| rng.random_range(-300.0..1000.0));
        let away: [f32; 2] = std::array::from_fn(|_| rng.random_range(-9.0..9.0));
        let corner = [x + away[0], y + away[1], rng.random_range(-300.0..1000.0)];
        let vertices = [[x, y, ends[0]], [x, y, ends[1]], corner];
        let origin: [f32; 3] = std::array::from_fn(|k| [x, y, 0.0][k] + rng.random_range(-1.0..1.0));
        let at = [x, y, rng.random_range(1.0..8.0)];
        let direction: [f32; 3] = std::array::from_fn(|k| next_to(at[k] - origin[k], rng.random_range(-40..=40)));
        let bound =
            |of: fn(f32, f32) -> f32| std::array::from_fn(|k| of(vertices[0][k], of(vertices[1][k], vertices[2][k])));
        let case = Case { origin, direction, extent: f32::INFINITY, min: bound(f32::min), max: bound(f32::max) };
        let ray = Ray::new(origin, direction, f32::INFINITY).expect("a ray");
        let [a, b, c] = vertices.map(Into::into);
        let input = RayTriangleExtendedInput { ray, triangle: Triangle { a, b, c }, t_min: 0.0.into() };
        if bool::from(triangles.run(Binary32, input, ()).0.triangle_hit) {
            let (plain, conservative) = case.hits();
            assert!(conservative, "{vertices:?} is hit, {case:?} is missed");
            hits += 1;
            without += usize::from(!plain);
            by_a_factor += usize::from(!case.is_hit_with_a_factor());
        }
    }
    assert!(hits > 10_000 && without > 100 && by_a_factor > 10, "{hits} hits, {without} and {by_a_factor} missed");
}
