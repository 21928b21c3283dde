//! Jobs in binary64, before a host rounds them to a format.

use raypath_model::{Binary64, Double};
use raypath_ops::{
    Aabb, Beat, BeatInput, Bit, Circuit, Concrete, Flags, Job, JobKind, Num, PortKind, Ray, RayBoxInput,
    RayTriangleInput, Slab, Triangle, Vec3, Word,
};

/// Coordinates along x, y and z.
pub type Point = [f64; 3];

/// A job of one of the paper's four operations, with 16 or 8 lanes per beat, none masked off.
pub type HostJob = Job<16, 8, Binary64>;

/// The ray of unlimited extent from `origin` along `direction`. `None` if [`Ray::new`] rejects the direction.
pub fn ray(origin: Point, direction: Point) -> Option<Ray<Binary64>> {
    let single = Ray::new([0.0; 3], direction.map(|d| d as f32), f32::INFINITY).ok()?;
    let axes = [single.kx, single.ky, single.kz].map(u32::from);
    let [x, y, z] = axes.map(|axis| direction[axis as usize]);
    let [kx, ky, kz] = axes.map(|axis| Word::new(Binary64, axis));
    let (dir, inv, shear) = (vector(direction), direction.map(|d| 1.0 / d), [x / z, y / z, 1.0 / z]);
    let extent = Binary64.infinity();
    Some(Ray { origin: vector(origin), dir, inv: vector(inv), extent, shear: vector(shear), kx, ky, kz })
}

/// A ray against four boxes, each with its minimum and its maximum corner.
pub fn quadbox(ray: Ray<Binary64>, boxes: [[Point; 2]; 4]) -> HostJob {
    let aabb = boxes.map(|[min, max]| {
        let slab = |axis: usize| Slab { min: number(min[axis]), max: number(max[axis]) };
        Aabb { x: slab(0), y: slab(1), z: slab(2) }
    });
    Job::Quadbox(RayBoxInput { ray, aabb })
}

/// A ray against a triangle.
pub fn triangle(ray: Ray<Binary64>, vertices: [Point; 3]) -> HostJob {
    let [a, b, c] = vertices.map(vector);
    Job::Triangle(RayTriangleInput { ray, triangle: Triangle { a, b, c } })
}

/// A beat of a distance; the sums are complete with the last.
pub fn beat<const N: usize>(a: [f64; N], b: [f64; N], last: bool) -> BeatInput<Binary64, N> {
    let bit = |value| Bit::new(Binary64, value);
    let (mask, reset_accum) = (Flags([bit(true); N]), bit(last));
    BeatInput { euclidean: Beat { a: a.map(number), b: b.map(number), mask, reset_accum } }
}

fn number(x: f64) -> Num<Binary64> {
    Num::new(Binary64, Double(x))
}

fn vector(v: Point) -> Vec3<Binary64> {
    let [x, y, z] = v.map(number);
    Vec3 { x, y, z }
}

/// The conversion of jobs to other circuits.
pub struct Rounding {
    /// For each kind of job, which of its words are numbers.
    are_numbers: [Vec<bool>; 4],
}

impl Rounding {
    pub fn new() -> Self {
        let of_kind = |kind| {
            let ports = HostJob::from_words_in(Binary64, kind, &[]).ports();
            ports.iter().map(|port| port.kind == PortKind::Number).collect()
        };
        Self { are_numbers: JobKind::ALL.map(of_kind) }
    }

    /// The job in a circuit's numbers, whose bits `rounded` returns.
    pub fn job<C: Concrete>(&self, job: &HostJob, circuit: C, rounded: impl Fn(f64) -> u64) -> Job<16, 8, C> {
        let mut words = Vec::new();
        job.words(&mut words);
        for (word, is_number) in words.iter_mut().zip(&self.are_numbers[job.kind() as usize]) {
            if *is_number {
                *word = rounded(f64::from_bits(*word));
            }
        }
        Job::from_words_in(circuit, job.kind(), &words)
    }
}

/// The vector of length 1 in the same direction.
pub fn unit(v: Point) -> Point {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    v.map(|coordinate| coordinate / length)
}

#[cfg(test)]
mod tests {
    use super::{Rounding, quadbox, ray, triangle};
    use raypath_ops::{Aabb, Binary32, Job, Ray, RayBoxInput, RayTriangleInput, Triangle};

    /// If binary32 rounds nothing, a host's job equals the job that the types of binary32 make.
    #[test]
    fn jobs_are_those_of_binary32() {
        let binary32 = |job| Rounding::new().job(&job, Binary32, |x| (x as f32).to_bits().into());
        for direction in [[1.0, 2.0, -4.0], [-8.0, 0.5, 4.0], [0.25, 2.0, -0.0]] {
            let ray = ray([1.0, 2.0, 3.0], direction).expect("a ray");
            let expected = Ray::new([1.0, 2.0, 3.0], direction.map(|d| d as f32), f32::INFINITY).expect("a ray");

            let boxes = [0.0, 1.0, 2.0, 3.0].map(|x| [[x, 0.0, -1.0], [x + 1.0, 5.0, 6.0]]);
            let aabb = [0.0, 1.0, 2.0, 3.0].map(|x| Aabb::new([x, 0.0, -1.0], [x + 1.0, 5.0, 6.0]));
            let expected_boxes: Job = Job::Quadbox(RayBoxInput { ray: expected, aabb });
            assert_eq!(binary32(quadbox(ray, boxes)), expected_boxes);

            let vertices = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.5]];
            let corners = Triangle::new([1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.5]);
            let expected_triangle: Job = Job::Triangle(RayTriangleInput { ray: expected, triangle: corners });
            assert_eq!(binary32(triangle(ray, vertices)), expected_triangle);
        }
        assert!(ray([0.0; 3], [0.0; 3]).is_none());
    }
}
