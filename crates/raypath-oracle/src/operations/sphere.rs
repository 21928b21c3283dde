//! Stimulus and oracle of [`Sphere`]: the oracle computes the quadratic equation in exact rationals.

use crate::{AnyOperationSpec, OperationSpec, draw, exact};
use num_rational::BigRational;
use rand::{Rng, RngExt};
use raypath_ops::operations::sphere::{Ball, Quadratic, Sphere, SphereInput, SphereOutput};
use raypath_ops::{Binary32, Ray};

/// The specification of [`Sphere`].
pub fn spec() -> AnyOperationSpec {
    OperationSpec::of(Sphere)
        .purpose("a ray against a sphere: particles, hair, bounding spheres")
        .stimulus(stimulus)
        .oracle("exact rationals", check)
        .into()
}

/// A ray that passes the centre of a sphere at a known fraction of its radius: through it, beside it, or grazing. The
/// sphere may be small and distant, around the origin, or behind it; a number may be at the limits of binary32.
pub fn stimulus(rng: &mut impl Rng) -> SphereInput<Binary32> {
    let radius = draw::spread(rng, -6..6);
    let distance = rng.random_range(0.0..4.0) * 2.0_f32.powi(rng.random_range(-6..14));
    let centre = draw::three(|| if rng.random() { draw::whole(rng) } else { rng.random_range(-100.0..100.0) });
    let unit = |rng: &mut _| {
        loop {
            let v = draw::three(|| RngExt::random_range(rng, -1.0_f32..1.0));
            let length = v.iter().map(|x| x * x).sum::<f32>().sqrt();
            if (0.1..1.0).contains(&length) {
                return v.map(|x| x / length);
            }
        }
    };
    let (towards, other) = (unit(rng), unit(rng));
    // The distance between centre and ray.
    let share = [0.0, 0.5, 0.999, 0.999_999, 1.0, 1.000_001, 1.001, 2.0][rng.random_range(0..8)] * radius;
    let along: f32 = (0..3).map(|k| towards[k] * other[k]).sum();
    let across: [f32; 3] = std::array::from_fn(|k| other[k] - along * towards[k]);
    let length = across.iter().map(|x| x * x).sum::<f32>().sqrt().max(1e-3);
    let stretch = draw::spread(rng, -10..10);
    let mut origin: [f32; 3] = std::array::from_fn(|k| centre[k] - distance * towards[k] + share / length * across[k]);
    let mut dir = towards.map(|x| x * stretch);
    let (mut centre, mut radius) = (centre, radius);
    if rng.random_bool(0.05) {
        let scale = 2.0_f32.powi(rng.random_range(-90..60));
        for number in origin.iter_mut().chain(&mut dir).chain(&mut centre).chain([&mut radius]) {
            *number *= scale;
        }
    }
    if rng.random_bool(0.1) {
        let field: &mut f32 = match rng.random_range(0..10) {
            0..3 => &mut origin[rng.random_range(0..3)],
            3..6 => &mut dir[rng.random_range(0..3)],
            6..9 => &mut centre[rng.random_range(0..3)],
            _ => &mut radius,
        };
        *field = draw::edge(rng);
    }
    // The fields that the operation does not read come from another ray.
    let ray = draw::ray_at(rng, [1.0; 3]);
    SphereInput {
        ray: Ray { origin: origin.into(), dir: dir.into(), ..ray },
        sphere: Ball { centre: centre.into(), radius: radius.into() },
    }
}

/// Compares a result with the exact equation, within bounds of the rounding errors.
///
/// Each rounding has a relative error of at most u = 2⁻²⁴, or an absolute error of at most 2⁻¹⁵⁰ if it underflows. With
/// `n = f × d`, and `m` the same sum with all products positive, the error bounds are:
/// - 4 u a for a, 5 u Σ|fᵢ dᵢ| for b, and 7 u f·f + 3 u r² for c;
/// - eᵢ = 4 u mᵢ for nᵢ, and Σ(2 |nᵢ| eᵢ + eᵢ²) + 6 u Σ(|nᵢ| + eᵢ)² + 8 u r² a for the discriminant.
///
/// Relative to r² a, the error of the discriminant is of order u |f| / r. That of b² - a c would be of order u (|f| /
/// r)². No bounds hold if a value overflows.
///
/// # Errors
/// A number outside its bound; a hit bit that does not follow from the four numbers, or that is wrong although the
/// bounds determine it.
pub fn check(job: &SphereInput<Binary32>, answer: &SphereOutput<Binary32>) -> Result<(), String> {
    let Quadratic { a, b, c, discriminant, hit } = answer.sphere;
    let [af, bf, cf, df] = [a, b, c, discriminant].map(f32::from);
    let hit = bool::from(hit);
    let follows = df >= 0.0 && af > 0.0 && ((bf >= 0.0 && !cf.is_nan()) || (cf <= 0.0 && !bf.is_nan()));
    if hit != follows {
        return Err(format!("hit is {hit}, but a {af:e}, b {bf:e}, c {cf:e}, discriminant {df:e} say {follows}"));
    }
    let Some(exact) = Exact::of(job) else { return Ok(()) };
    for (name, found, [expected, bound]) in [
        ("a", a, &exact.a),
        ("b", b, &exact.b),
        ("c", c, &exact.c),
        ("discriminant", discriminant, &exact.discriminant),
    ] {
        let far = exact::value(found).is_none_or(|found| exact::absolute(&(found - expected)) > *bound);
        if far {
            return Err(format!("{name} is {:e}, expected {expected} within {bound}", f32::from(found)));
        }
    }
    let above_zero = |[number, bound]: &[BigRational; 2]| {
        if number > bound { Some(true) } else { (*number < -bound).then_some(false) }
    };
    let expected = match [&exact.discriminant, &exact.b, &exact.c].map(above_zero) {
        [Some(false), ..] | [Some(true), Some(false), Some(true)] => Some(false),
        [Some(true), Some(true), _] | [Some(true), _, Some(false)] => Some(true),
        _ => None,
    };
    match expected.filter(|_| above_zero(&exact.a) == Some(true)) {
        Some(expected) if expected != hit => Err(format!("hit is {hit}, but exactly it is {expected}")),
        _ => Ok(()),
    }
}

/// The exact numbers of the equation, each with the bound of its error.
struct Exact {
    a: [BigRational; 2],
    b: [BigRational; 2],
    c: [BigRational; 2],
    discriminant: [BigRational; 2],
}

impl Exact {
    /// `None` if an input is not finite or a value could overflow.
    fn of(job: &SphereInput<Binary32>) -> Option<Self> {
        let (centre, origin) = (exact::values(job.sphere.centre)?, exact::values(job.ray.origin)?);
        let d = exact::values(job.ray.dir)?;
        let radius = exact::value(job.sphere.radius)?;
        let u = |times: i32| exact::power(-24) * BigRational::from_integer(times.into());
        let least = exact::power(-147);

        let f: [BigRational; 3] = std::array::from_fn(|k| &centre[k] - &origin[k]);
        let pairs = [(1, 2), (2, 0), (0, 1)];
        let n = pairs.map(|(j, k)| exact::absolute(&(&f[j] * &d[k] - &f[k] * &d[j])));
        let m = pairs.map(|(j, k)| exact::absolute(&(&f[j] * &d[k])) + exact::absolute(&(&f[k] * &d[j])));
        let e = m.clone().map(|m| u(4) * m + &least);
        let [a, ff] = [&d, &f].map(|v| v.iter().map(|x| x * x).sum::<BigRational>());
        let b: BigRational = (0..3).map(|k| &f[k] * &d[k]).sum();
        let b_terms: BigRational = (0..3).map(|k| exact::absolute(&(&f[k] * &d[k]))).sum();
        let square = &radius * &radius;
        let reach = &square * &a;
        let apart: BigRational = n.iter().map(|n| n * n).sum();
        let near: BigRational = (0..3).map(|i| (&n[i] + &e[i]) * (&n[i] + &e[i])).sum();
        let largest = [&a, &ff, &square, &reach, &near, &b_terms].into_iter().chain(&m).chain(&f).max()?.clone();
        if largest >= exact::power(127) {
            return None;
        }

        let off: BigRational = (0..3).map(|i| &e[i] * (&n[i] + &n[i] + &e[i])).sum();
        let one = exact::power(0);
        let bound = off + u(6) * near + u(8) * &reach + &least * (&a + &square + one);
        Some(Self {
            discriminant: [reach - apart, bound],
            c: [&ff - &square, u(7) * ff + u(3) * square + &least],
            b: [b, u(5) * b_terms + &least],
            a: [a.clone(), u(4) * a + least],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::{check_operation, jobs};
    use raypath_ops::{Num, Operation};

    check_operation!(Sphere, SphereInput, SphereOutput);

    fn job(origin: [f32; 3], dir: [f32; 3], centre: [f32; 3], radius: f32) -> SphereInput<Binary32> {
        let ray = Ray::new([0.0; 3], [1.0; 3], f32::INFINITY).expect("a ray");
        let ray = Ray { origin: origin.into(), dir: dir.into(), ..ray };
        SphereInput { ray, sphere: Ball { centre: centre.into(), radius: radius.into() } }
    }

    fn run(job: SphereInput<Binary32>) -> ([f32; 4], bool) {
        let (answer, ()) = Sphere.run(Binary32, job, ());
        check(&job, &answer).expect("a right answer");
        let Quadratic { a, b, c, discriminant, hit } = answer.sphere;
        ([a, b, c, discriminant].map(f32::from), hit.into())
    }

    #[test]
    fn by_hand() {
        let along_z = [0.0, 0.0, 2.0];
        // The solutions are t = 2 and 3, at 4 and 6 along z.
        assert_eq!(run(job([0.0; 3], along_z, [0.0, 0.0, 5.0], 1.0)), ([4.0, 10.0, 24.0, 4.0], true));
        assert_eq!(run(job([0.0; 3], along_z, [0.0, 0.0, -5.0], 1.0)), ([4.0, -10.0, 24.0, 4.0], false));
        assert_eq!(run(job([0.0; 3], along_z, [0.0, 0.0, -0.5], 1.0)), ([4.0, -1.0, -0.75, 4.0], true));
        assert_eq!(run(job([1.0, 0.0, 0.0], along_z, [0.0, 0.0, 5.0], 1.0)), ([4.0, 10.0, 25.0, 0.0], true));
        assert_eq!(run(job([2.0, 0.0, 0.0], along_z, [0.0, 0.0, 5.0], -1.0)), ([4.0, 10.0, 28.0, -12.0], false));
    }

    #[test]
    fn at_the_edges() {
        let (inf, nan) = (f32::INFINITY, f32::NAN);
        let hit = |job| run(job).1;
        assert!(hit(job([0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0; 3], 1.0)), "starts on the sphere, towards the inside");
        assert!(hit(job([0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0; 3], 1.0)), "starts on the sphere, away from it");
        assert!(hit(job([0.0; 3], [0.0, 0.0, 1.0], [0.0, 0.0, 3.0], 0.0)), "a point on the ray");
        assert!(!hit(job([0.0; 3], [0.0; 3], [0.0; 3], 1.0)), "no direction");
        assert!(!hit(job([0.0; 3], [0.0, 0.0, 1e-30], [0.0, 0.0, 3.0], 1.0)), "a direction whose square is zero");
        assert!(!hit(job([0.0; 3], [0.0, nan, 1.0], [0.0, 0.0, 3.0], 1.0)));
        assert!(!hit(job([nan, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3], inf)));
        assert!(!hit(job([0.0; 3], [0.0, 0.0, inf], [0.0, 0.0, 3.0], 1.0)), "0 times infinity");
    }

    /// A sphere of radius 1 at a distance of 4,096, passed at 0.9 or 1.1. b² - a c would be 0.
    #[test]
    fn small_spheres_far_away() {
        let (a, distance) = (1.0_f32, 4096.0_f32);
        assert_eq!(distance * distance - a * (distance * distance + 1.1 * 1.1 - 1.0), 0.0);
        for (side, hits) in [(0.9, true), (1.1, false)] {
            let ([.., discriminant], hit) = run(job([0.0; 3], [0.0, 0.0, 1.0], [side, 0.0, distance], 1.0));
            assert!((discriminant - (1.0 - side * side)).abs() < 1e-6 && hit == hits, "{side}: {discriminant}");
        }
    }

    fn number_of(equation: &mut Quadratic<Binary32>, i: usize) -> &mut Num<Binary32> {
        let Quadratic { a, b, c, discriminant, .. } = equation;
        [a, b, c, discriminant].into_iter().nth(i).expect("one of four")
    }

    #[test]
    fn wrong_answers_are_refused() {
        let (mut negated, mut hits) = (0, 0);
        for job in jobs(stimulus, 1000) {
            let (right, ()) = Sphere.run(Binary32, job, ());
            hits += i32::from(bool::from(right.sphere.hit));
            let mut wrong = right;
            wrong.sphere.hit = !wrong.sphere.hit;
            assert!(check(&job, &wrong).is_err());
            let Some(exact) = Exact::of(&job) else { continue };
            let numbers = [exact.a, exact.b, exact.c, exact.discriminant];
            for (i, [number, bound]) in numbers.into_iter().enumerate() {
                let mut wrong = right;
                *number_of(&mut wrong.sphere, i) = f32::NAN.into();
                assert!(check(&job, &wrong).is_err());
                if exact::absolute(&number) > bound {
                    negated += 1;
                    let mut wrong = right;
                    let number = number_of(&mut wrong.sphere, i);
                    *number = -*number;
                    assert!(check(&job, &wrong).is_err());
                }
            }
        }
        assert!(negated > 2500 && (300..700).contains(&hits), "{negated} numbers with a certain sign, {hits} hits");
    }
}
