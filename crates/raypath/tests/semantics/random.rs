//! Random jobs, reproducible by seed.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath::ops::{Aabb, Job, JobKind, Ray, RayBoxInput, RayTriangleInput, Triangle};

pub fn rng(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// A distribution of numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Numbers {
    /// Few small integers: ties, cancellation to zero, flat boxes.
    SmallIntegers,
    /// Uniform in [-1, 1]: rounding in every operation.
    Unit,
    /// Any exponent, including subnormal and overflowing numbers.
    WideExponents,
    /// Zeros, infinities, NaNs with payloads, extremes, among small integers.
    Specials,
    /// Any 32 bits.
    RawBits,
}

impl Numbers {
    pub const ALL: [Self; 5] = [Self::SmallIntegers, Self::Unit, Self::WideExponents, Self::Specials, Self::RawBits];

    pub fn draw(self, rng: &mut ChaCha8Rng) -> f32 {
        const SPECIALS: [u32; 12] = [
            0x0000_0000,
            0x8000_0000,
            0x7f80_0000,
            0xff80_0000,
            0x7fc0_0000,
            0xffc0_1234,
            0x7f80_0001,
            0x0000_0001,
            0x8000_0001,
            0x007f_ffff,
            0x7f7f_ffff,
            0xff7f_ffff,
        ];
        match self {
            Self::SmallIntegers => rng.random_range(-4..=4) as f32,
            Self::Unit => unit(rng),
            Self::WideExponents => {
                let bits = rng.random::<u32>();
                // With most exponents, squares underflow or overflow sometimes, not always.
                let exponent = if rng.random_bool(0.01) { rng.random_range(0..255) } else { rng.random_range(60..192) };
                f32::from_bits(bits & 0x807f_ffff | exponent << 23)
            }
            Self::Specials if rng.random_bool(0.1) => f32::from_bits(SPECIALS[rng.random_range(0..SPECIALS.len())]),
            Self::Specials => rng.random_range(-4..=4) as f32,
            Self::RawBits => f32::from_bits(rng.random()),
        }
    }
}

/// Uniform in [-1, 1], with 24 significant bits for small numbers too. A number drawn as binary32 would be a multiple
/// of 2^-23, and sums would not round.
fn unit(rng: &mut ChaCha8Rng) -> f32 {
    rng.random_range(-1.0..=1.0_f64) as f32
}

/// A job whose fields are independent random numbers; no field of a ray is derived from its direction.
pub fn any_job(kind: JobKind, numbers: Numbers, rng: &mut ChaCha8Rng) -> Job {
    // With few lanes, numbers of any size seldom overflow.
    let lanes_on = [0.1, 0.8, 1.0][rng.random_range(0..3)];
    Job::from_ports(kind, |name| match name {
        _ if name.ends_with("reset_accum") => rng.random_bool(0.2).into(),
        _ if name.ends_with("mask") => u64::from(rng.random_bool(lanes_on)) * u64::MAX,
        _ if name.starts_with("ray_k") => rng.random_range(0..4),
        _ => numbers.draw(rng).to_bits().into(),
    })
}

/// A ray at four boxes or a triangle as in a renderer; many are hit.
pub fn scene_job(rng: &mut ChaCha8Rng) -> Job {
    let mut point = |range: f32| -> [f32; 3] { std::array::from_fn(|_| range * unit(rng)) };
    let origin = point(4.0);
    let target = point(0.5);
    let direction = std::array::from_fn(|axis| target[axis] - origin[axis]);
    let ray = Ray::new(origin, direction, f32::INFINITY).unwrap();
    let aabb = std::array::from_fn(|_| {
        let (a, b): ([f32; 3], [f32; 3]) = (point(1.0), point(1.0));
        Aabb::new(std::array::from_fn(|i| a[i].min(b[i])), std::array::from_fn(|i| a[i].max(b[i])))
    });
    let triangle = Triangle::new(point(1.0), point(1.0), point(1.0));
    if rng.random() {
        Job::Quadbox(RayBoxInput { ray, aabb })
    } else {
        Job::Triangle(RayTriangleInput { ray, triangle })
    }
}

/// All operations and all distributions, mixed.
pub fn mixed_jobs(count: usize, seed: u64) -> Vec<Job> {
    let mut rng = rng(seed);
    (0..count)
        .map(|_| {
            if rng.random_bool(0.3) {
                return scene_job(&mut rng);
            }
            let kind = JobKind::ALL[rng.random_range(0..JobKind::ALL.len())];
            let numbers = Numbers::ALL[rng.random_range(0..Numbers::ALL.len())];
            any_job(kind, numbers, &mut rng)
        })
        .collect()
}
