//! Jobs in binary64, before a host rounds them to a format.

use raypath_ops::{
    Aabb, Beat, BeatInput, Bit, Concrete, Flags, Job, Num, Ray, RayBoxInput, RayTriangleInput, Slab, Triangle, Vec3,
    Word,
};

/// Coordinates along x, y and z.
pub type Point = [f64; 3];

/// A ray of unlimited extent, with the values derived from its direction. The scale of a scene applies to the origin
/// and not to the direction.
#[derive(Debug, Clone, Copy)]
pub struct HostRay {
    origin: Point,
    direction: Point,
    inverse: Point,
    shear: Point,
    axes: [u32; 3],
}

/// A job of one of the paper's four operations, with 16 or 8 lanes per beat, none masked off.
#[derive(Debug, Clone, Copy)]
#[allow(clippy::large_enum_variant)] // jobs are streamed by value; boxing would allocate for each
pub enum HostJob {
    /// A ray against four boxes, each with its minimum and its maximum corner.
    Quadbox { ray: HostRay, boxes: [[Point; 2]; 4] },
    /// A ray against a triangle.
    Triangle { ray: HostRay, vertices: [Point; 3] },
    /// A beat of a Euclidean distance; the sum is complete with the last.
    Euclidean { a: [f64; 16], b: [f64; 16], last: bool },
    /// A beat of an angular distance; the sums are complete with the last.
    Angular { a: [f64; 8], b: [f64; 8], last: bool },
}

impl HostRay {
    /// The ray from `origin` along `direction`. None if [`Ray::new`] refuses the direction.
    pub fn new(origin: Point, direction: Point) -> Option<Self> {
        let single = Ray::new([0.0; 3], direction.map(|d| d as f32), f32::INFINITY).ok()?;
        let axes = [single.kx, single.ky, single.kz].map(u32::from);
        let [x, y, z] = axes.map(|axis| direction[axis as usize]);
        let shear = [x / z, y / z, 1.0 / z];
        Some(Self { origin, direction, inverse: direction.map(|d| 1.0 / d), shear, axes })
    }
}

impl HostJob {
    /// The job in a circuit's numbers: coordinates times `scale`, then everything rounded by `number`.
    pub fn job<C: Concrete>(&self, scale: f64, circuit: C, number: impl Fn(f64) -> C::Num) -> Job<16, 8, C> {
        let rounding = Rounding { scale, circuit, number };
        match self {
            Self::Quadbox { ray, boxes } => {
                Job::Quadbox(RayBoxInput { ray: rounding.ray(ray), aabb: boxes.map(|corners| rounding.aabb(corners)) })
            }
            Self::Triangle { ray, vertices } => {
                let [a, b, c] = vertices.map(|vertex| rounding.point(vertex));
                Job::Triangle(RayTriangleInput { ray: rounding.ray(ray), triangle: Triangle { a, b, c } })
            }
            Self::Euclidean { a, b, last } => Job::Euclidean(BeatInput { euclidean: rounding.beat(a, b, *last) }),
            Self::Angular { a, b, last } => Job::Angular(BeatInput { euclidean: rounding.beat(a, b, *last) }),
        }
    }
}

/// The conversion of a host's numbers to a circuit's.
struct Rounding<C, F> {
    scale: f64,
    circuit: C,
    number: F,
}

impl<C: Concrete, F: Fn(f64) -> C::Num> Rounding<C, F> {
    fn number(&self, number: f64) -> Num<C> {
        Num::new(self.circuit, (self.number)(number))
    }

    fn coordinate(&self, coordinate: f64) -> Num<C> {
        self.number(coordinate * self.scale)
    }

    /// A vector that does not grow with the scene.
    fn vector(&self, vector: Point) -> Vec3<C> {
        let [x, y, z] = vector.map(|component| self.number(component));
        Vec3 { x, y, z }
    }

    fn point(&self, point: Point) -> Vec3<C> {
        let [x, y, z] = point.map(|coordinate| self.coordinate(coordinate));
        Vec3 { x, y, z }
    }

    fn aabb(&self, [min, max]: [Point; 2]) -> Aabb<C> {
        let slab = |axis: usize| Slab { min: self.coordinate(min[axis]), max: self.coordinate(max[axis]) };
        Aabb { x: slab(0), y: slab(1), z: slab(2) }
    }

    fn ray(&self, ray: &HostRay) -> Ray<C> {
        let [kx, ky, kz] = ray.axes.map(|axis| Word::new(self.circuit, axis));
        Ray {
            origin: self.point(ray.origin),
            dir: self.vector(ray.direction),
            inv: self.vector(ray.inverse),
            extent: self.circuit.infinity(),
            shear: self.vector(ray.shear),
            kx,
            ky,
            kz,
        }
    }

    fn beat<const N: usize>(&self, a: &[f64; N], b: &[f64; N], last: bool) -> Beat<C, N> {
        Beat {
            a: a.map(|coordinate| self.coordinate(coordinate)),
            b: b.map(|coordinate| self.coordinate(coordinate)),
            mask: Flags([Bit::new(self.circuit, true); N]),
            reset_accum: Bit::new(self.circuit, last),
        }
    }
}

/// The vector of length 1 in the same direction.
pub fn unit(v: Point) -> Point {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    v.map(|coordinate| coordinate / length)
}

#[cfg(test)]
mod tests {
    use super::{HostJob, HostRay};
    use raypath_ops::{Aabb, Binary32, Job, Ray, RayBoxInput, RayTriangleInput, Single, Triangle};

    /// Where binary32 rounds nothing, a host's job is the job that the types of binary32 make.
    #[test]
    fn jobs_are_those_of_binary32() {
        let binary32 = |job: HostJob| job.job(1.0, Binary32, |x| Single(x as f32));
        for direction in [[1.0, 2.0, -4.0], [-8.0, 0.5, 4.0], [0.25, 2.0, -0.0]] {
            let ray = HostRay::new([1.0, 2.0, 3.0], direction).expect("a ray");
            let expected = Ray::new([1.0, 2.0, 3.0], direction.map(|d| d as f32), f32::INFINITY).expect("a ray");

            let boxes = [0.0, 1.0, 2.0, 3.0].map(|x| [[x, 0.0, -1.0], [x + 1.0, 5.0, 6.0]]);
            let aabb = [0.0, 1.0, 2.0, 3.0].map(|x| Aabb::new([x, 0.0, -1.0], [x + 1.0, 5.0, 6.0]));
            let expected_boxes: Job = Job::Quadbox(RayBoxInput { ray: expected, aabb });
            assert_eq!(binary32(HostJob::Quadbox { ray, boxes }), expected_boxes);

            let vertices = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.5]];
            let triangle = Triangle::new([1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.5]);
            let expected_triangle: Job = Job::Triangle(RayTriangleInput { ray: expected, triangle });
            assert_eq!(binary32(HostJob::Triangle { ray, vertices }), expected_triangle);
        }
        assert!(HostRay::new([0.0; 3], [0.0; 3]).is_none());
    }
}
