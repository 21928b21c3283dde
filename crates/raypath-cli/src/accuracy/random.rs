//! Random jobs: rays aimed at boxes and triangles near the origin, and vectors.

use super::host::{HostJob, Point, beat, quadbox, ray, triangle, unit};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_model::Binary64;
use raypath_ops::{Job, Ray};

/// The dimensions of vectors: several beats, so that accumulation is measured too.
pub const DIMENSIONS: usize = 64;

/// An endless stream of random jobs, reproducible by seed.
pub struct RandomJobs {
    rng: ChaCha8Rng,
    /// A factor on all coordinates.
    scale: f64,
}

impl RandomJobs {
    pub fn new(seed: u64, scale: f64) -> Self {
        Self { rng: ChaCha8Rng::seed_from_u64(seed), scale }
    }

    /// The jobs of a round: one of each kind; a distance is a job per beat.
    pub fn round(&mut self) -> Vec<HostJob> {
        let mut jobs = vec![self.quadbox(), self.triangle()];
        let (a, b) = (self.vector(), self.vector());
        jobs.extend(beats(&a, &b, |a, b, last| Job::Euclidean(beat(a, b, last))));
        jobs.extend(beats(&a, &b, |a, b, last| Job::Angular(beat(a, b, last))));
        jobs
    }

    /// Four boxes, and a ray aimed at a point near their centres.
    fn quadbox(&mut self) -> HostJob {
        let target = self.point(1.0);
        let ray = self.ray_to(target);
        let boxes = std::array::from_fn(|_| {
            let (centre, half) = (self.point(1.0), self.point(0.5).map(f64::abs));
            let corner = |side: f64| std::array::from_fn(|i| (centre[i] + side * half[i]) * self.scale);
            [corner(-1.0), corner(1.0)]
        });
        quadbox(ray, boxes)
    }

    /// A triangle, and a ray aimed at a point inside or just outside.
    fn triangle(&mut self) -> HostJob {
        let vertices @ [a, b, c] = [self.point(1.0), self.point(1.0), self.point(1.0)];
        let [u, v, w]: [f64; 3] = std::array::from_fn(|_| self.rng.random_range(-0.1..1.0));
        let target = std::array::from_fn(|i| (u * a[i] + v * b[i] + w * c[i]) / (u + v + w));
        triangle(self.ray_to(target), vertices.map(|vertex| self.scaled(vertex)))
    }

    fn ray_to(&mut self, target: Point) -> Ray<Binary64> {
        loop {
            let origin = self.point(4.0);
            let direction = unit(std::array::from_fn(|i| target[i] - origin[i]));
            // An origin equal to the target gives no ray: try another.
            if let Some(ray) = ray(self.scaled(origin), direction) {
                return ray;
            }
        }
    }

    fn scaled(&self, point: Point) -> Point {
        point.map(|coordinate| coordinate * self.scale)
    }

    fn point(&mut self, reach: f64) -> Point {
        std::array::from_fn(|_| self.rng.random_range(-reach..reach))
    }

    fn vector(&mut self) -> [f64; DIMENSIONS] {
        std::array::from_fn(|_| self.rng.random_range(-1.0..1.0) * self.scale)
    }
}

/// The beats of two vectors, `N` lanes each.
fn beats<const N: usize>(
    a: &[f64; DIMENSIONS],
    b: &[f64; DIMENSIONS],
    beat: impl Fn([f64; N], [f64; N], bool) -> HostJob,
) -> impl Iterator<Item = HostJob> {
    const { assert!(DIMENSIONS.is_multiple_of(N), "the lanes must divide the dimensions") };
    let lanes = |vector: &[f64; DIMENSIONS], first: usize| std::array::from_fn(|lane| vector[first + lane]);
    let last = DIMENSIONS - N;
    (0..DIMENSIONS).step_by(N).map(move |first| beat(lanes(a, first), lanes(b, first), first == last))
}
