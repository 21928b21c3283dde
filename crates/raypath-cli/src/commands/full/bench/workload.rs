//! The jobs of the measurements: rays aimed at boxes and triangles from all sides, and vectors. There are no subnormal
//! or special numbers, which are slow on some machines. The jobs differ, so that a branch predictor cannot learn them.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_ops::{Aabb, Beat, BeatInput, Binary32, Flags, Job, Num, Ray, RayBoxInput, RayTriangleInput, Triangle};

/// Random jobs with a fixed seed.
pub struct Workload {
    rng: ChaCha8Rng,
}

impl Workload {
    pub fn new() -> Self {
        Self { rng: ChaCha8Rng::seed_from_u64(1) }
    }

    /// Jobs of the four operations in turn.
    pub fn mixed(&mut self, count: usize) -> Vec<Job> {
        let job = |i| match i % 4 {
            0 => Job::Triangle(self.triangle()),
            1 => Job::Quadbox(self.quadbox()),
            2 => Job::Euclidean(BeatInput { euclidean: self.beat(i % 64 == 2) }),
            _ => Job::Angular(BeatInput { euclidean: self.beat(i % 64 == 3) }),
        };
        (0..count).map(job).collect()
    }

    /// A ray and four boxes. About half of the boxes are hit.
    pub fn quadbox(&mut self) -> RayBoxInput<Binary32> {
        let ray = self.ray();
        let corner = |a: f32, b: f32| (a.min(b), a.max(b));
        let aabb = std::array::from_fn(|_| {
            let (a, b): ([f32; 3], [f32; 3]) = (self.point(1.0), self.point(1.0));
            let sides: [(f32, f32); 3] = std::array::from_fn(|k| corner(a[k], b[k]));
            Aabb::new(sides.map(|side| side.0), sides.map(|side| side.1))
        });
        RayBoxInput { ray, aabb }
    }

    pub fn triangle(&mut self) -> RayTriangleInput<Binary32> {
        let (ray, [a, b, c]) = (self.ray(), std::array::from_fn(|_| self.point(1.0)));
        RayTriangleInput { ray, triangle: Triangle::new(a, b, c) }
    }

    pub fn beat<const N: usize>(&mut self, is_last: bool) -> Beat<Binary32, N> {
        let mut vector =
            || -> [Num<Binary32>; N] { std::array::from_fn(|_| self.rng.random_range(-1.0f32..1.0).into()) };
        Beat { a: vector(), b: vector(), mask: Flags::from_mask(u64::MAX), reset_accum: is_last.into() }
    }

    fn ray(&mut self) -> Ray<Binary32> {
        loop {
            let (origin, target): ([f32; 3], [f32; 3]) = (self.point(4.0), self.point(0.7));
            if let Ok(ray) = Ray::new(origin, std::array::from_fn(|k| target[k] - origin[k]), f32::INFINITY) {
                return ray;
            }
        }
    }

    fn point(&mut self, reach: f32) -> [f32; 3] {
        std::array::from_fn(|_| self.rng.random_range(-reach..reach))
    }
}
