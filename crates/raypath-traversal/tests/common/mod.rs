//! A ray along the z axis, and triangles around that axis.

use raypath_ops::Triangle;
use raypath_traversal::RayRequest;
use raypath_traversal::blocks::LeafTriangle;

/// A ray from z = -1 in the direction of z, without an end.
pub fn along_z(root: u32) -> RayRequest {
    RayRequest {
        origin: [0.0, 0.0, -1.0],
        direction: [0.0, 0.0, 1.0],
        t_min: 0.0,
        t_max: f32::INFINITY,
        any_hit: false,
        cull_back: false,
        cull_front: false,
        root,
    }
}

/// A triangle around the z axis at a depth.
pub fn at(z: f32, index: u32) -> LeafTriangle {
    LeafTriangle { triangle: Triangle::new([-1.0, -1.0, z], [0.0, 2.0, z], [1.0, -1.0, z]), index }
}
