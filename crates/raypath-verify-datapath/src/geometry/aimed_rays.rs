//! Rays aimed at the edges and vertices of closed meshes.

use super::mesh::{Mesh, Patch};
use super::shapes::shapes;
use super::vector::{Point, dot, minus, scaled, sum, unit};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use raypath_ops::{Binary32, Ray};
use std::borrow::Cow;

/// A mesh at a place in space, with the patches that rays are aimed at.
pub struct PlacedMesh {
    pub mesh: Mesh,
    centre: Point,
    radius: f64,
    normals: Vec<Point>,
    edges: Vec<([usize; 2], Patch)>,
    fans: Vec<Patch>,
}

/// The target of a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// A point of an edge. The patch is its two faces.
    Edge,
    /// A vertex. The patch is the faces around it.
    Vertex,
    /// A point near the centre. The patch is all faces that face the ray.
    Whole,
}

/// A ray, and the patch that it must hit.
pub struct AimedRay<'b> {
    pub target: Target,
    pub ray: Ray<Binary32>,
    pub patch: Cow<'b, Patch>,
}

/// Every shape at several places and in several sizes.
pub fn bodies(seed: u64) -> Vec<PlacedMesh> {
    let places = [
        (1.0, [0.0; 3]),
        (2_f64.powi(12), [3.0, -1000.0, 77.0]),
        (2_f64.powi(-10), [0.0, 0.0, 0.0]),
        (1.0, [-13.7, 2.9, 31.4]),
    ];
    let shapes = shapes(seed);
    let placed = shapes.iter().flat_map(|mesh| places.map(|(scale, offset)| mesh.placed(scale, offset)));
    placed.map(PlacedMesh::new).collect()
}

impl PlacedMesh {
    fn new(mesh: Mesh) -> Self {
        let (centre, radius) = mesh.ball();
        let normals = (0..mesh.faces.len()).map(|face| mesh.normal(face)).collect();
        let edges = mesh.edges().into_iter().map(|(ends, sides)| (ends, mesh.patch(sides.to_vec()))).collect();
        let fans = mesh.fans().into_iter().map(|fan| mesh.patch(fan)).collect();
        Self { mesh, centre, radius, normals, edges, fans }
    }

    /// A random ray; none if its random direction is zero.
    pub fn random_ray(&self, rng: &mut ChaCha8Rng) -> Option<AimedRay<'_>> {
        let vertex = |vertex: usize| self.mesh.vertices[vertex].map(f64::from);
        match rng.random_range(0..128) {
            0 => {
                let off = scaled(self.random_unit(rng), self.radius * rng.random_range(0.0..0.7));
                let outwards = self.random_unit(rng);
                let ray = self.ray(rng, sum(self.centre, off), outwards)?;
                let direction = ray.dir.into();
                let faces_ray = |&face: &usize| super::visibility::faces_direction(direction, self.mesh.corners(face));
                let patch = self.mesh.patch((0..self.mesh.faces.len()).filter(faces_ray).collect());
                Some(AimedRay { target: Target::Whole, ray, patch: Cow::Owned(patch) })
            }
            1..64 => {
                let (ends, patch) = &self.edges[rng.random_range(0..self.edges.len())];
                let [a, b] = ends.map(vertex);
                let target = sum(a, scaled(minus(b, a), fraction(rng)));
                let ray = self.ray(rng, target, self.outwards(patch))?;
                Some(AimedRay { target: Target::Edge, ray, patch: Cow::Borrowed(patch) })
            }
            _ => {
                let target = rng.random_range(0..self.fans.len());
                let patch = &self.fans[target];
                let ray = self.ray(rng, vertex(target), self.outwards(patch))?;
                Some(AimedRay { target: Target::Vertex, ray, patch: Cow::Borrowed(patch) })
            }
        }
    }

    /// The direction of a patch's normals.
    fn outwards(&self, patch: &Patch) -> Point {
        unit(patch.faces.iter().map(|&face| self.normals[face]).fold([0.0; 3], sum))
    }

    /// A ray at `target`, from near or far, from a random side around `outwards`. One in three has a direction of small
    /// integers, so that it can pass exactly through the target. Half of the others are moved by one or two ulps.
    fn ray(&self, rng: &mut ChaCha8Rng, target: Point, outwards: Point) -> Option<Ray<Binary32>> {
        let tilt = [0.0, 0.2, 0.5, 1.0, 3.0][rng.random_range(0..5)];
        let backwards = sum(outwards, scaled(self.random_unit(rng), tilt));
        let (backwards, distance) = if rng.random_range(0..3) == 0 {
            let greatest = backwards.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
            (backwards.map(|x| (x / greatest * 4.0).round()), self.power_of_two(rng))
        } else {
            (backwards, self.radius * rng.random_range(-4.0..7.0_f64).exp2())
        };
        let origin = sum(target, scaled(backwards, distance)).map(|x| x as f32);
        let length = [1.0, 1.0, 1.0 / 1024.0, 4096.0][rng.random_range(0..4)] / self.radius;
        let length = length.log2().round().exp2();
        let towards = minus(target, origin.map(f64::from)).map(|x| (x * length) as f32);
        let is_moved = rng.random();
        let direction =
            towards.map(|x| if is_moved && x != 0.0 { offset_by_ulps(x, rng.random_range(-2..=2)) } else { x });
        Ray::new(origin, direction, f32::INFINITY).ok()
    }

    fn power_of_two(&self, rng: &mut ChaCha8Rng) -> f64 {
        (self.radius.log2().round() + f64::from(rng.random_range(-3..6))).exp2()
    }

    fn random_unit(&self, rng: &mut ChaCha8Rng) -> Point {
        loop {
            let point = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
            if (0.01..1.0).contains(&dot(point, point)) {
                return unit(point);
            }
        }
    }
}

/// A position on an edge: a half, quarter or eighth, anywhere, or very near an end.
fn fraction(rng: &mut ChaCha8Rng) -> f64 {
    let fraction = match rng.random_range(0..4) {
        0 => [0.5, 0.25, 0.125][rng.random_range(0..3)],
        1 => (-rng.random_range(1.0..30.0_f64)).exp2(),
        _ => rng.random_range(0.0..1.0),
    };
    if rng.random() { fraction } else { 1.0 - fraction }
}

/// The number this many ulps away.
fn offset_by_ulps(x: f32, ulps: i32) -> f32 {
    f32::from_bits(x.to_bits().wrapping_add_signed(ulps))
}
