//! Faces, barycentric coordinates and range of the extended triangle test, and several accumulators, compared with
//! exact arithmetic.

use num_rational::BigRational;
use rand::rngs::ChaCha8Rng;
use rand::{Rng, RngExt, SeedableRng};
use raypath_ops::{
    AngularMany, AngularManyState, Beat, BeatManyInput, Binary32, Culling, EuclideanMany, EuclideanManyState, Flags,
    Operation, Ray, RayTriangle, RayTriangleExtended, RayTriangleExtendedInput, RayTriangleExtendedOutput,
    RayTriangleInput, Rounding, Rules, Triangle, Word, from_words, ports_of,
};

const PLAIN: RayTriangleExtended = RayTriangleExtended::PLAIN;

const CULLINGS: [Culling; 3] = [Culling::Back, Culling::Front, Culling::None];

type Vector = [BigRational; 3];

fn exact(number: f32) -> BigRational {
    BigRational::from_float(number).expect("a finite number")
}

fn minus(a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|axis| &a[axis] - &b[axis])
}

fn determinant(a: &Vector, b: &Vector, c: &Vector) -> BigRational {
    let cross = |i: usize, j: usize| &b[i] * &c[j] - &b[j] * &c[i];
    &a[0] * cross(1, 2) + &a[1] * cross(2, 0) + &a[2] * cross(0, 1)
}

/// The intersection of a ray with the plane of a triangle, by Cramer's rule: the weights of the vertices, the distance,
/// and the face.
struct Met {
    weights: [BigRational; 3],
    distance: BigRational,
    is_front: bool,
}

fn meet(origin: [f32; 3], direction: [f32; 3], vertices: [[f32; 3]; 3]) -> Option<Met> {
    let zero = exact(0.0);
    let [origin, direction] = [origin, direction].map(|of| of.map(exact));
    let [a, b, c] = vertices.map(|vertex| vertex.map(exact));
    // origin + t direction = a + v (b - a) + w (c - a)
    let (ab, ac, to) = (minus(&b, &a), minus(&c, &a), minus(&origin, &a));
    let back = direction.map(|component| -component);
    let whole = determinant(&back, &ab, &ac);
    if whole == zero {
        return None;
    }
    let distance = determinant(&to, &ab, &ac) / &whole;
    let v = determinant(&back, &to, &ac) / &whole;
    let w = determinant(&back, &ab, &to) / &whole;
    let u = exact(1.0) - &v - &w;
    Some(Met { weights: [u, v, w], distance, is_front: whole > zero })
}

fn run(
    operation: RayTriangleExtended,
    ray: Ray<Binary32>,
    vertices: [[f32; 3]; 3],
    t_min: f32,
) -> RayTriangleExtendedOutput<Binary32> {
    let [a, b, c] = vertices;
    let job = RayTriangleExtendedInput { ray, triangle: Triangle::new(a, b, c), t_min: t_min.into() };
    operation.run(Binary32, job, ()).0
}

/// Small integers, and a direction whose shear is exact, which make all results before the bounds exact.
fn whole(rng: &mut impl Rng) -> ([f32; 3], [f32; 3], [[f32; 3]; 3]) {
    let mut small = || rng.random_range(-4..=4) as f32;
    let origin = std::array::from_fn(|_| small());
    let vertices = std::array::from_fn(|_| std::array::from_fn(|_| small()));
    let mut direction: [f32; 3] = std::array::from_fn(|_| small());
    direction[rng.random_range(0..3)] = if rng.random() { 8.0 } else { -8.0 };
    (origin, direction, vertices)
}

#[test]
fn faces_and_coordinates_are_exact() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (mut edges, mut hits) = (0, [0; 3]);
    for _ in 0..30_000 {
        let (origin, direction, vertices) = whole(&mut rng);
        let ray = Ray::new(origin, direction, f32::INFINITY).expect("a ray");
        let met = meet(origin, direction, vertices);
        let zero = exact(0.0);
        let inside = met.as_ref().is_some_and(|met| met.weights.iter().all(|weight| *weight >= zero));
        edges += usize::from(inside && met.as_ref().is_some_and(|met| met.weights.contains(&zero)));
        for (culling, hits) in CULLINGS.into_iter().zip(&mut hits) {
            for rules in [Rules::Paper, Rules::Chisel] {
                let operation = RayTriangleExtended { rules, culling, facing: true, barycentrics: true, ..PLAIN };
                let found = run(operation, ray, vertices, 0.0);
                let expected = met.as_ref().is_some_and(|met| {
                    // Under the rules `chisel`, a distance of zero is a hit.
                    let before = met.distance > zero || rules == Rules::Chisel && met.distance == zero;
                    let seen = match culling {
                        Culling::Back => met.is_front,
                        Culling::Front => !met.is_front,
                        Culling::None => true,
                    };
                    inside && before && seen
                });
                assert_eq!(bool::from(found.triangle_hit), expected, "{operation:?} {ray:?} {vertices:?}");
                assert_eq!(bool::from(found.facing), met.as_ref().is_some_and(|met| met.is_front));
                *hits += usize::from(expected);
                let denominator = exact(found.t_denom.into());
                assert_eq!(denominator == zero, met.is_none());
                let Some(met) = &met else { continue };
                let weights = [found.barycentric.u, found.barycentric.v, found.barycentric.w];
                assert_eq!(weights.map(|weight| exact(weight.into()) / &denominator), met.weights);
                assert_eq!(exact(found.t_num.into()) / &denominator, met.distance);
            }
        }
    }
    assert!(edges > 100 && hits.iter().all(|hits| *hits > 500), "{edges} at edges, {hits:?}");
    assert!(hits[2] == hits[0] + hits[1]);
}

/// With bounds at, just before and just after the distance, a hit in range is never missed, and a hit out of range by
/// more than one rounding is never reported.
#[test]
fn range_is_exact_but_for_one_rounding() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let (mut inside, mut outside, mut rounded) = (0, 0, 0);
    while inside < 3_000 || outside < 3_000 {
        let (origin, direction, vertices) = whole(&mut rng);
        let Some(met) = meet(origin, direction, vertices) else { continue };
        let zero = exact(0.0);
        if met.distance <= zero || met.weights.iter().any(|weight| *weight < zero) {
            continue;
        }
        let ray = Ray::new(origin, direction, f32::INFINITY).expect("a ray");
        let unbounded = RayTriangleExtended { culling: Culling::None, ..PLAIN };
        let found = run(unbounded, ray, vertices, 0.0);
        assert!(bool::from(found.triangle_hit));
        let distance = f32::from(found.t_num) / f32::from(found.t_denom);
        let mut bound = || f32::from_bits(distance.to_bits().wrapping_add_signed(rng.random_range(-2..=2)));
        let ends = [(0.0, f32::INFINITY), (bound(), f32::INFINITY), (0.0, bound()), (bound(), bound()), (-1.0, 1e30)];
        for (t_min, extent) in ends {
            let ray = Ray::new(origin, direction, extent).expect("a ray");
            for rules in [Rules::Paper, Rules::Chisel] {
                let culling = if rng.random() { Culling::None } else { facing_only(met.is_front) };
                let operation = RayTriangleExtended { rules, culling, range: true, ..PLAIN };
                let hit = bool::from(run(operation, ray, vertices, t_min).triangle_hit);
                let within = |slack: f32| {
                    let far_enough = met.distance >= exact(t_min) * exact(1.0 - slack);
                    far_enough && (extent.is_infinite() || met.distance <= exact(extent) * exact(1.0 + slack))
                };
                let is_inside = within(0.0);
                assert!(hit || !is_inside, "{operation:?} {ray:?} {t_min} {vertices:?} is refused");
                assert!(!hit || within(f32::EPSILON), "{operation:?} {ray:?} {t_min} {vertices:?} is taken");
                // Exact products give an exact result.
                let is_exact = |bound: f32| {
                    let product = exact(bound) * exact(found.t_denom.into());
                    product == exact(bound * f32::from(found.t_denom))
                };
                if is_exact(t_min) && (extent.is_infinite() || is_exact(extent)) {
                    assert_eq!(hit, is_inside);
                }
                (inside, outside) = (inside + usize::from(is_inside), outside + usize::from(!is_inside));
                rounded += usize::from(hit != is_inside);
                // The other face is not hit.
                let other = RayTriangleExtended { culling: facing_only(!met.is_front), ..operation };
                assert!(!bool::from(run(other, ray, vertices, t_min).triangle_hit));
            }
        }
    }
    assert!(rounded > 0, "no rounding was met, so the bound on it is not tested");
}

/// The culling mode with which only this face is hit.
fn facing_only(is_front: bool) -> Culling {
    if is_front { Culling::Back } else { Culling::Front }
}

#[test]
fn what_breaks_down_is_ruled() {
    // Counter-clockwise seen along z, with x to the left.
    let front = [[1.0, -1.0, 2.0], [-1.0, -1.0, 2.0], [0.0, 1.0, 2.0]];
    let back = [front[1], front[0], front[2]];
    let of = |extent: f32| {
        let mut ray = Ray::new([0.0; 3], [0.0, 0.0, 1.0], f32::INFINITY).expect("a ray");
        ray.extent = extent.into();
        ray
    };
    let hit = |rules, culling, vertices, t_min: f32, extent: f32| {
        let operation = RayTriangleExtended { rules, culling, range: true, ..PLAIN };
        bool::from(run(operation, of(extent), vertices, t_min).triangle_hit)
    };
    let (nan, infinity) = (f32::NAN, f32::INFINITY);
    for (seen, hidden, culling) in [(front, back, Culling::Back), (back, front, Culling::Front)] {
        for rules in [Rules::Paper, Rules::Chisel] {
            let chisel = rules == Rules::Chisel;
            // No bounds, both bounds at the distance, the distance outside.
            assert!(hit(rules, culling, seen, 0.0, infinity) && hit(rules, culling, seen, 2.0, 2.0));
            assert!(hit(rules, culling, seen, -0.0, infinity) && hit(rules, culling, seen, -infinity, infinity));
            assert!(!hit(rules, culling, seen, 2.5, infinity) && !hit(rules, culling, seen, 0.0, 1.5));
            assert!(!hit(rules, culling, hidden, 0.0, infinity));
            assert!(hit(rules, Culling::None, seen, 0.0, infinity) && hit(rules, Culling::None, hidden, 2.0, 2.0));
            // A NaN bound is neither in range nor out of range.
            assert_eq!(hit(rules, culling, seen, nan, infinity), chisel);
            assert_eq!(hit(rules, culling, seen, 0.0, nan), chisel);
            // A NaN among the vertices.
            let broken = [[nan, 0.0, 2.0], seen[1], seen[2]];
            assert_eq!(hit(rules, culling, broken, 0.0, infinity), chisel);
            assert_eq!(hit(rules, Culling::None, broken, 0.0, infinity), chisel);
            // An edge-on triangle has a denominator of zero and is a miss.
            let edge_on = [[0.0, -1.0, 1.0], [0.0, 1.0, 1.0], [0.0, 0.0, 2.0]];
            assert!(!hit(rules, culling, edge_on, 0.0, infinity) && !hit(rules, Culling::None, edge_on, 0.0, 1e9));
            // If the denominator overflows, its product with a bound of zero is NaN.
            let huge = seen.map(|[x, y, z]| [x * 1e25, y * 1e25, z]);
            assert_eq!(hit(rules, culling, huge, 0.0, infinity), chisel);
        }
    }
    let facing =
        |vertices| bool::from(run(RayTriangleExtended { facing: true, ..PLAIN }, of(infinity), vertices, 0.0).facing);
    assert!(facing(front) && !facing(back) && !facing([[nan; 3]; 3]));
}

#[test]
fn the_default_is_the_configuration_of_the_paper() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let count = ports_of::<RayTriangleExtendedInput<Binary32>>().len();
    let special = [0.0_f32, -0.0, 1.0, -1.0, f32::INFINITY, f32::NAN, 1e-42, 3e38].map(f32::to_bits);
    for round in 0..50_000 {
        let words: Vec<u64> = (0..count)
            .map(|_| match round % 3 {
                0 => rng.random::<u32>().into(),
                1 => special[rng.random_range(0..special.len())].into(),
                _ => u64::from((rng.random_range(-4..=4) as f32).to_bits()),
            })
            .collect();
        let job: RayTriangleExtendedInput<Binary32> = from_words(Binary32, &words);
        for rules in [Rules::Paper, Rules::Chisel] {
            let found = RayTriangleExtended { rules, ..PLAIN }.run(Binary32, job, ()).0;
            let plain = RayTriangle { rules, rounding: Rounding::Unit };
            let expected = plain.run(Binary32, RayTriangleInput { ray: job.ray, triangle: job.triangle }, ()).0;
            assert_eq!(
                (found.t_num, found.t_denom, found.triangle_hit),
                (expected.t_num, expected.t_denom, expected.triangle_hit)
            );
        }
    }
}

/// Beats of several vectors are interleaved at random, and each sum belongs to its own vector.
#[test]
fn accumulators_do_not_mix() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let zero = || 0.0.into();
    let mut euclidean = EuclideanManyState { accumulator: [zero(); 8] };
    let mut angular = AngularManyState { dot_product: [zero(); 8], norm: [zero(); 8] };
    let mut sums = [[0_i32; 3]; 8];
    let mut resets = 0;
    for _ in 0..20_000 {
        let which = rng.random_range(0..8);
        let [a, b]: [[i32; 4]; 2] = std::array::from_fn(|_| std::array::from_fn(|_| rng.random_range(-9..=9)));
        let mask: [bool; 4] = rng.random();
        let reset: bool = rng.random_bool(0.2);
        let beat = Beat {
            a: a.map(|a| (a as f32).into()),
            b: b.map(|b| (b as f32).into()),
            mask: Flags::new(mask),
            reset_accum: reset.into(),
        };
        let accumulator = Word::truncate(which as u32);
        let found;
        (found, euclidean) = EuclideanMany::<4, 8, 3> { rounding: Rounding::Unit }.run(
            Binary32,
            BeatManyInput { euclidean: beat, accumulator },
            euclidean,
        );
        let products;
        (products, angular) = AngularMany::<4, 8, 3> { rounding: Rounding::Unit }.run(
            Binary32,
            BeatManyInput { euclidean: beat, accumulator },
            angular,
        );
        for lane in (0..4).filter(|&lane| mask[lane]) {
            sums[which][0] += (a[lane] - b[lane]).pow(2);
            sums[which][1] += a[lane] * b[lane];
            sums[which][2] += b[lane] * b[lane];
        }
        let [square, dot, norm] = sums[which].map(|sum| sum as f32);
        assert_eq!(f32::from(found.euclidean_accumulator), square);
        assert_eq!(f32::from(products.angular_dot_product), dot);
        assert_eq!(f32::from(products.angular_norm), norm);
        assert_eq!((bool::from(found.euclidean_reset_accum), bool::from(products.angular_reset_accum)), (reset, reset));
        if reset {
            sums[which] = [0; 3];
            resets += 1;
        }
    }
    assert!(resets > 1_000);
}

#[test]
fn ports_follow_the_options() {
    let off = PLAIN;
    let on = RayTriangleExtended { facing: true, barycentrics: true, range: true, ..PLAIN };
    let gone = |operation: RayTriangleExtended| {
        let outputs = ports_of::<RayTriangleExtendedOutput<Binary32>>();
        let inputs = ports_of::<RayTriangleExtendedInput<Binary32>>();
        let outputs = outputs.into_iter().filter(|port| !operation.has_output(&port.name));
        let inputs = inputs.into_iter().filter(|port| !operation.has_input(&port.name));
        outputs.chain(inputs).map(|port| port.name).collect::<Vec<_>>()
    };
    assert_eq!(gone(off), ["barycentric_u", "barycentric_v", "barycentric_w", "facing", "t_min"]);
    assert!(gone(on).is_empty());
}
