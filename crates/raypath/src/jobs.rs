//! Random jobs that are worth running: scenes where rays are aimed at things, and numbers from the edges of the format.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use raypath_ops::{Aabb, Job, JobKind, Ray, RayBoxInput, RayTriangleInput, Triangle};

/// An endless stream of jobs of these kinds, reproducible by `seed`: three in four from a scene, one in four with
/// numbers from the edges (zeros, subnormals, infinities, NaN, raw bits). `kinds` must not be empty.
pub fn random(seed: u64, kinds: &[JobKind]) -> impl Iterator<Item = Job> {
    let mut generator = Generator { rng: ChaCha8Rng::seed_from_u64(seed), kinds: kinds.to_vec() };
    std::iter::repeat_with(move || generator.job())
}

struct Generator {
    rng: ChaCha8Rng,
    kinds: Vec<JobKind>,
}

/// Numbers at which rules decide.
const EDGES: [u32; 16] = [
    0x0000_0000, // 0
    0x8000_0000, // -0
    0x0000_0001, // smallest subnormal
    0x807f_ffff, // largest subnormal, negative
    0x0080_0000, // smallest normal
    0x3f80_0000, // 1
    0xbf80_0000, // -1
    0x3f80_0001, // 1 and an ulp
    0x3f00_0000, // 1/2
    0x4000_0000, // 2
    0x1fff_ffff, // a square of it is subnormal
    0x5f00_0000, // 2^63: a square of it is near the largest
    0x7f7f_ffff, // largest
    0x7f80_0000, // infinity
    0xff80_0000, // -infinity
    0x7fc0_0000, // NaN
];

impl Generator {
    fn job(&mut self) -> Job {
        let kind = self.kinds[self.rng.random_range(0..self.kinds.len())];
        match kind {
            JobKind::Triangle | JobKind::Quadbox if self.rng.random_bool(0.75) => self.scene(kind),
            _ => self.ports(kind),
        }
    }

    /// A ray aimed at one of the boxes, or at a place in or near the triangle.
    fn scene(&mut self, kind: JobKind) -> Job {
        let (origin, a, b, c) = (self.point(4.0), self.point(1.0), self.point(1.0), self.point(1.0));
        let [u, v, w]: [f32; 3] = std::array::from_fn(|_| self.rng.random_range(-0.1..1.0));
        let target: [f32; 3] = std::array::from_fn(|i| (u * a[i] + v * b[i] + w * c[i]) / (u + v + w));
        let direction = std::array::from_fn(|i| target[i] - origin[i]);
        let extent = if self.rng.random_bool(0.8) { f32::INFINITY } else { self.rng.random_range(0.0..2.0) };
        // Only a direction of zero or a division by zero above is refused; any other scene will do instead.
        let Ok(ray) = Ray::new(origin, direction, extent) else { return self.scene(kind) };
        if kind == JobKind::Triangle {
            return Job::Triangle(RayTriangleInput { ray, triangle: Triangle::new(a, b, c) });
        }
        let aabb = std::array::from_fn(|_| {
            let (centre, half) = (self.point(1.0), self.point(0.5).map(f32::abs));
            Aabb::new(std::array::from_fn(|i| centre[i] - half[i]), std::array::from_fn(|i| centre[i] + half[i]))
        });
        Job::Quadbox(RayBoxInput { ray, aabb })
    }

    /// A job whose ports are drawn one by one; in one of three many of its numbers are at the edges.
    fn ports(&mut self, kind: JobKind) -> Job {
        let edges = if self.rng.random_bool(0.33) { 0.5 } else { 0.01 };
        let rng = &mut self.rng;
        Job::from_ports(kind, |port| match port {
            "ray_kx" | "ray_ky" | "ray_kz" => rng.random_range(0..4),
            "euclidean_mask" if rng.random_bool(0.5) => u64::MAX,
            "euclidean_reset_accum" => rng.random_bool(0.1).into(),
            _ if rng.random_bool(edges) => EDGES[rng.random_range(0..EDGES.len())].into(),
            _ if rng.random_bool(0.05) => rng.random(),
            _ => rng.random_range(-1.0f32..1.0).to_bits().into(),
        })
    }

    fn point(&mut self, reach: f32) -> [f32; 3] {
        std::array::from_fn(|_| self.rng.random_range(-reach..reach))
    }
}
