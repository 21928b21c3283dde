//! A ray along the z axis, triangles around that axis, and vectors in binary64.

use raypath_ops::Triangle;
use raypath_traversal::RayRequest;
use raypath_traversal::blocks::LeafTriangle;

/// A ray from z = -1 in the direction of z, without an end.
pub fn along_z(root: u32) -> RayRequest {
    RayRequest { origin: [0.0, 0.0, -1.0], root, ..RayRequest::NONE }
}

/// A triangle around the z axis at a depth.
pub fn at(z: f32, index: u32) -> LeafTriangle {
    LeafTriangle { triangle: Triangle::new([-1.0, -1.0, z], [0.0, 2.0, z], [1.0, -1.0, z]), index }
}

pub fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
