//! `Ray::new`: derived values (`docs/reference/semantics.md`) and errors.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_ops::{Binary32, Ray, RayError};

const INF: f32 = f32::INFINITY;

fn inv(ray: Ray<Binary32>) -> [u32; 3] {
    <[f32; 3]>::from(ray.inv).map(f32::to_bits)
}

/// For all directions of a grid, kz is the first axis of the greatest absolute value, which the paper's listing omits.
/// kx, ky and kz have a cyclic order that a negative sign of dir[kz] reverses.
#[test]
fn the_axes_of_a_grid_of_directions() {
    let values = [-2.0, -1.0, -0.0, 0.0, 1.0, 2.0];
    for x in values {
        for y in values {
            for z in values {
                let direction: [f32; 3] = [x, y, z];
                if direction == [0.0; 3] {
                    continue;
                }
                let greatest = direction.iter().map(|d| d.abs()).fold(0.0, f32::max);
                let kz = direction.iter().position(|d| d.abs() == greatest).unwrap() as u32;
                let (next, next_but_one) = ((kz + 1) % 3, (kz + 2) % 3);
                let expected =
                    if direction[kz as usize] < 0.0 { [next_but_one, next, kz] } else { [next, next_but_one, kz] };
                let ray = Ray::new([0.0; 3], direction, INF).unwrap();
                assert_eq!([ray.kx, ray.ky, ray.kz].map(u32::from), expected, "{direction:?}");
            }
        }
    }
}

#[test]
fn the_inverse_of_a_zero_is_infinity_of_its_sign() {
    let ray = Ray::new([0.0; 3], [0.0, -0.0, 4.0], INF).unwrap();
    assert_eq!(inv(ray), [INF, -INF, 0.25].map(f32::to_bits));
    let ray = Ray::new([0.0; 3], [-0.0, -4.0, 0.0], INF).unwrap();
    assert_eq!(inv(ray), [-INF, -0.25, INF].map(f32::to_bits));
}

#[test]
fn shear_is_by_the_permuted_axes() {
    // kz = 2, forwards: kx = 0, ky = 1.
    let ray = Ray::new([0.0; 3], [1.0, 2.0, 4.0], INF).unwrap();
    assert_eq!(<[f32; 3]>::from(ray.shear), [0.25, 0.5, 0.25]);
    // kz = 2, backwards: kx = 1, ky = 0.
    let ray = Ray::new([0.0; 3], [1.0, 2.0, -4.0], INF).unwrap();
    assert_eq!(<[f32; 3]>::from(ray.shear), [-0.5, -0.25, -0.25]);
    // kz = 0, forwards: kx = 1, ky = 2.
    let ray = Ray::new([0.0; 3], [8.0, 2.0, -4.0], INF).unwrap();
    assert_eq!(<[f32; 3]>::from(ray.shear), [0.25, -0.5, 0.125]);
}

#[test]
fn origin_direction_and_extent_keep_their_bits() {
    let (origin, direction) = ([-0.0, 1e-45, f32::MAX], [-0.0, -1e-40, 3.0]);
    for extent in [0.0, -0.0, 1e-45, 2.5, INF] {
        let ray = Ray::new(origin, direction, extent).unwrap();
        assert_eq!(<[f32; 3]>::from(ray.origin).map(f32::to_bits), origin.map(f32::to_bits));
        assert_eq!(<[f32; 3]>::from(ray.dir).map(f32::to_bits), direction.map(f32::to_bits));
        assert_eq!(ray.extent.to_bits(), extent.to_bits());
    }
}

/// `quotient` is the binary32 number nearest to n/d, ties to even: n/d lies between the midpoints to its neighbours.
/// Midpoints have 25 bits and d has 24, so that their product is exact in binary64.
fn is_correctly_rounded(quotient: f32, n: f32, d: f32) -> bool {
    if n == 0.0 || d == 0.0 {
        return quotient.to_bits() == (n / d).to_bits();
    }
    let signs_agree = quotient.is_sign_negative() == (n.is_sign_negative() != d.is_sign_negative());
    let (q, n, d) = (quotient.abs(), f64::from(n.abs()), f64::from(d.abs()));
    let even = q.to_bits() & 1 == 0;
    let midpoint = |a: f32, b: f32| (f64::from(a) + f64::from(b)) / 2.0;
    let above_lower = match q {
        0.0 => true,
        // Numbers from half a step above the largest number round to infinity.
        INF => n >= (f64::from(f32::MAX) + 2f64.powi(103)) * d,
        _ => {
            let lower = midpoint(q.next_down(), q) * d;
            lower < n || even && lower == n
        }
    };
    let below_upper = match q {
        INF => true,
        f32::MAX => n < (f64::from(f32::MAX) + 2f64.powi(103)) * d,
        _ => {
            let upper = midpoint(q, q.next_up()) * d;
            n < upper || even && n == upper
        }
    };
    signs_agree && above_lower && below_upper
}

#[test]
fn the_quotients_are_correctly_rounded() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut component = || match rng.random_range(0..4) {
        0 => [0.0, -0.0, 1.0, -3.0][rng.random_range(0..4)],
        1 => rng.random_range(-1.0..=1.0_f64) as f32,
        _ => f32::from_bits(rng.random()),
    };
    let mut rays = 0;
    for _ in 0..100_000 {
        let direction = [component(), component(), component()];
        let Ok(ray) = Ray::new([0.0; 3], direction, INF) else { continue };
        rays += 1;
        let [kx, ky, kz] = [ray.kx, ray.ky, ray.kz].map(|k| direction[u32::from(k) as usize]);
        let shear: [f32; 3] = ray.shear.into();
        for (quotient, n) in shear.into_iter().zip([kx, ky, 1.0]) {
            assert!(is_correctly_rounded(quotient, n, kz), "{quotient:e} for {n:e} / {kz:e}");
        }
        for (quotient, d) in <[f32; 3]>::from(ray.inv).into_iter().zip(direction) {
            assert!(is_correctly_rounded(quotient, 1.0, d), "{quotient:e} for 1 / {d:e}");
        }
    }
    assert!(rays > 50_000, "{rays}");
}

/// A test of `is_correctly_rounded`.
#[test]
fn a_neighbour_is_not_correctly_rounded() {
    let third = 1.0_f32 / 3.0;
    assert!(is_correctly_rounded(third, 1.0, 3.0));
    assert!(!is_correctly_rounded(third.next_up(), 1.0, 3.0));
    assert!(!is_correctly_rounded(third.next_down(), 1.0, 3.0));
    assert!(!is_correctly_rounded(-third, 1.0, 3.0));
    assert!(!is_correctly_rounded(f32::MAX, 1.0, 1e-45));
    assert!(is_correctly_rounded(INF, 1.0, 1e-45));
}

/// The error and its message.
fn rejected(origin: [f32; 3], direction: [f32; 3], extent: f32) -> (RayError, String) {
    let error = Ray::new(origin, direction, extent).unwrap_err();
    (error, error.to_string())
}

#[test]
fn a_direction_of_zeros_is_rejected() {
    for direction in [[0.0; 3], [-0.0; 3], [0.0, -0.0, 0.0]] {
        let (error, _) = rejected([0.0; 3], direction, INF);
        assert!(matches!(error, RayError::ZeroDirection(d) if d.map(f32::to_bits) == direction.map(f32::to_bits)));
    }
    let message = "direction (0, 0, 0) is zero, expected a direction of any other length";
    assert_eq!(rejected([0.0; 3], [0.0; 3], INF).1, message);
}

#[test]
fn directions_origins_and_extents_that_are_no_numbers_are_rejected() {
    for bad in [f32::NAN, INF, -INF] {
        for axis in 0..3 {
            let mut vector = [1.0; 3];
            vector[axis] = bad;
            let (error, message) = rejected([0.0; 3], vector, INF);
            assert!(matches!(error, RayError::DirectionNotFinite(_)), "{error:?}");
            assert!(
                message.starts_with("direction (") && message.ends_with("is not finite, expected three finite numbers")
            );
            let (error, message) = rejected(vector, [1.0; 3], INF);
            assert!(matches!(error, RayError::OriginNotFinite(_)), "{error:?}");
            assert!(
                message.starts_with("origin (") && message.ends_with("is not finite, expected three finite numbers")
            );
        }
        // Also among zeros.
        assert!(matches!(rejected([0.0; 3], [0.0, bad, 0.0], INF).0, RayError::DirectionNotFinite(_)));
    }
    for bad in [f32::NAN, -1.0, -f32::from_bits(1), -INF] {
        let (error, message) = rejected([0.0; 3], [1.0; 3], bad);
        assert!(matches!(error, RayError::Extent(_)), "{error:?}");
        assert_eq!(
            message,
            format!(
                "extent {bad} is not a valid distance, expected a number of at least 0 (infinity reaches everything)"
            )
        );
    }
}

/// 1/d overflows for |d| up to 2^-128: the shear would be infinite. The next number up is a ray.
#[test]
fn a_direction_too_short_to_invert_is_rejected() {
    let limit = 2f32.powi(-128);
    for short in [limit, -limit, f32::from_bits(1), limit.next_down()] {
        for axis in 0..3 {
            let mut direction = [0.0; 3];
            direction[axis] = short;
            let (error, message) = rejected([0.0; 3], direction, INF);
            assert_eq!(error, RayError::DirectionTooShort(direction));
            assert!(message.contains("is too short to invert"), "{message}");
        }
    }
    for long_enough in [limit.next_up(), -limit.next_up(), 2f32.powi(-127)] {
        let ray = Ray::new([0.0; 3], [0.0, long_enough, 0.0], INF).unwrap();
        let shear: [f32; 3] = ray.shear.into();
        assert!(shear.into_iter().all(f32::is_finite));
        assert!(is_correctly_rounded(shear[2], 1.0, long_enough));
    }
}
