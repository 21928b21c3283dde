//! Rays aimed at the edges and vertices of closed meshes.

use super::mesh::{Mesh, Patch};
use super::shapes::shapes;
use super::vector::{Point, dot, minus, scaled, sum, unit};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use raypath_ops::{Binary32, Ray};
use std::borrow::Cow;

/// A mesh somewhere in space, with the patches at which rays are aimed.
pub struct Body {
    /// The mesh.
    pub mesh: Mesh,
    centre: Point,
    radius: f64,
    normals: Vec<Point>,
    edges: Vec<([usize; 2], Patch)>,
    fans: Vec<Patch>,
}

/// At what a ray is aimed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Aim {
    /// A point of an edge; its two faces are the patch.
    Edge,
    /// A vertex; the faces around it are the patch.
    Vertex,
    /// A point about the middle; all faces that look at the ray are the patch.
    Whole,
}

/// A ray, and the patch through which it should not slip.
pub struct Shot<'b> {
    /// At what it is aimed.
    pub aim: Aim,
    /// The ray.
    pub ray: Ray<Binary32>,
    /// The patch.
    pub patch: Cow<'b, Patch>,
}

/// Every shape at several places and in several sizes.
pub fn bodies(seed: u64) -> Vec<Body> {
    let places = [
        (1.0, [0.0; 3]),
        (2_f64.powi(12), [3.0, -1000.0, 77.0]),
        (2_f64.powi(-10), [0.0, 0.0, 0.0]),
        (1.0, [-13.7, 2.9, 31.4]),
    ];
    let shapes = shapes(seed);
    let placed = shapes.iter().flat_map(|mesh| places.map(|(scale, offset)| mesh.placed(scale, offset)));
    placed.map(Body::new).collect()
}

impl Body {
    fn new(mesh: Mesh) -> Self {
        let (centre, radius) = mesh.ball();
        let normals = (0..mesh.faces.len()).map(|face| mesh.normal(face)).collect();
        let edges = mesh.edges().into_iter().map(|(ends, sides)| (ends, mesh.patch(sides.to_vec()))).collect();
        let fans = mesh.fans().into_iter().map(|fan| mesh.patch(fan)).collect();
        Self { mesh, centre, radius, normals, edges, fans }
    }

    /// A random ray; none where what was drawn is no ray.
    pub fn shoot(&self, rng: &mut ChaCha8Rng) -> Option<Shot<'_>> {
        let vertex = |vertex: usize| self.mesh.vertices[vertex].map(f64::from);
        match rng.random_range(0..128) {
            0 => {
                let off = scaled(self.random_unit(rng), self.radius * rng.random_range(0.0..0.7));
                let outwards = self.random_unit(rng);
                let ray = self.ray(rng, sum(self.centre, off), outwards)?;
                let direction = ray.dir.into();
                let looks = |&face: &usize| super::sight::looks_at(direction, self.mesh.corners(face));
                let patch = self.mesh.patch((0..self.mesh.faces.len()).filter(looks).collect());
                Some(Shot { aim: Aim::Whole, ray, patch: Cow::Owned(patch) })
            }
            1..64 => {
                let (ends, patch) = &self.edges[rng.random_range(0..self.edges.len())];
                let [a, b] = ends.map(vertex);
                let target = sum(a, scaled(minus(b, a), fraction(rng)));
                let ray = self.ray(rng, target, self.outwards(patch))?;
                Some(Shot { aim: Aim::Edge, ray, patch: Cow::Borrowed(patch) })
            }
            _ => {
                let target = rng.random_range(0..self.fans.len());
                let patch = &self.fans[target];
                let ray = self.ray(rng, vertex(target), self.outwards(patch))?;
                Some(Shot { aim: Aim::Vertex, ray, patch: Cow::Borrowed(patch) })
            }
        }
    }

    /// Where a patch looks.
    fn outwards(&self, patch: &Patch) -> Point {
        unit(patch.faces.iter().map(|&face| self.normals[face]).fold([0.0; 3], sum))
    }

    /// A ray at `target` from somewhere about where `outwards` points, from near or far. One in three has small
    /// integers as its direction, so that it passes exactly where it should if the target allows; of the others, half
    /// are nudged by an ulp or a few.
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
        let nudged = rng.random();
        let direction = towards.map(|x| if nudged && x != 0.0 { nudge(x, rng.random_range(-2..=2)) } else { x });
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

/// A place on an edge: the middle or a quarter, anywhere, or very near an end.
fn fraction(rng: &mut ChaCha8Rng) -> f64 {
    let fraction = match rng.random_range(0..4) {
        0 => [0.5, 0.25, 0.125][rng.random_range(0..3)],
        1 => (-rng.random_range(1.0..30.0_f64)).exp2(),
        _ => rng.random_range(0.0..1.0),
    };
    if rng.random() { fraction } else { 1.0 - fraction }
}

/// The number so many ulps away.
fn nudge(x: f32, ulps: i32) -> f32 {
    f32::from_bits(x.to_bits().wrapping_add_signed(ulps))
}
