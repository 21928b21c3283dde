//! Implementations of ray against triangle: the datapath, and others that let rays pass between faces.

use raypath_model::Functional;
use raypath_ops::{Binary32, Job, Outcome, Ray, RayTriangleInput, RayTriangleOutput, Rules, Triangle};

/// The datapath's result for a ray and a triangle.
pub fn datapath(rules: Rules, ray: &Ray<Binary32>, [a, b, c]: [[f32; 3]; 3]) -> RayTriangleOutput<Binary32> {
    let job = Job::Triangle(RayTriangleInput { ray: *ray, triangle: Triangle::new(a, b, c) });
    match Functional::<16, 8>::new(rules).run(&job) {
        Outcome::Triangle(output) => output,
        other => unreachable!("a triangle's outcome is no {other:?}"),
    }
}

/// An implementation and its name.
pub type Named = (&'static str, fn(&Ray<Binary32>, [[f32; 3]; 3]) -> bool);

/// Implementations that let rays pass between faces. They are the negative control of `watertight`: a campaign that
/// does not find these faults would not find a fault of the datapath.
pub const LEAKY: [Named; 3] =
    [("edges that belong to no face", open_edges), ("fused products", fused), ("Möller-Trumbore", moeller_trumbore)];

/// U, V, W > 0 instead of ≥ 0.
fn open_edges(ray: &Ray<Binary32>, corners: [[f32; 3]; 3]) -> bool {
    let [a, b, c] = sheared(ray, corners);
    let edge = |p: [f32; 2], q: [f32; 2]| p[0] * q[1] - p[1] * q[0];
    edge(c, b) > 0.0 && edge(a, c) > 0.0 && edge(b, a) > 0.0
}

/// One product of each edge function is not rounded, so that the ray can be outside of both faces of an edge.
fn fused(ray: &Ray<Binary32>, corners: [[f32; 3]; 3]) -> bool {
    let [a, b, c] = sheared(ray, corners);
    let edge = |p: [f32; 2], q: [f32; 2]| p[0].mul_add(q[1], -(p[1] * q[0]));
    edge(c, b) >= 0.0 && edge(a, c) >= 0.0 && edge(b, a) >= 0.0
}

/// Stages 2 to 4 of Table VII: x and y of each corner.
fn sheared(ray: &Ray<Binary32>, corners: [[f32; 3]; 3]) -> [[f32; 2]; 3] {
    let (origin, [sx, sy, _]) = (<[f32; 3]>::from(ray.origin), <[f32; 3]>::from(ray.shear));
    let [kx, ky, kz] = [ray.kx, ray.ky, ray.kz].map(|k| u32::from(k) as usize);
    corners.map(|corner| {
        let r: [f32; 3] = std::array::from_fn(|i| corner[i] - origin[i]);
        [r[kx] - sx * r[kz], r[ky] - sy * r[kz]]
    })
}

/// Möller and Trumbore's test in binary32: adjacent faces compute a common edge from different vertices.
fn moeller_trumbore(ray: &Ray<Binary32>, [a, b, c]: [[f32; 3]; 3]) -> bool {
    let (origin, d) = (<[f32; 3]>::from(ray.origin), <[f32; 3]>::from(ray.dir));
    let minus = |p: [f32; 3], q: [f32; 3]| -> [f32; 3] { std::array::from_fn(|i| p[i] - q[i]) };
    let dot = |p: [f32; 3], q: [f32; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let cross = |p: [f32; 3], q: [f32; 3]| -> [f32; 3] {
        std::array::from_fn(|i| p[(i + 1) % 3] * q[(i + 2) % 3] - p[(i + 2) % 3] * q[(i + 1) % 3])
    };
    let (e, f, from_a) = (minus(b, a), minus(c, a), minus(origin, a));
    let (p, q) = (cross(d, f), cross(from_a, e));
    let determinant = dot(e, p);
    let (v, w) = (dot(from_a, p), dot(d, q));
    determinant > 0.0 && v >= 0.0 && w >= 0.0 && v + w <= determinant && dot(f, q) > 0.0
}
