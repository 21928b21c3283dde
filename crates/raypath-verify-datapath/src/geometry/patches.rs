//! Random patches of faces around an edge or a vertex, and rays aimed at these.

use super::vector::{Point, cross, dot, minus, scaled, sum, unit};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use raypath_ops::{Binary32, Ray};

/// What the faces of a patch share, and a ray is aimed at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// An edge of two faces.
    Edge,
    /// A vertex of three to eight faces around it.
    Vertex,
}

/// Faces that share an edge or a vertex, counter-clockwise as seen from outside.
#[derive(Debug, Clone)]
pub struct Patch {
    /// What they share.
    pub target: Target,
    /// The vertices of all faces.
    pub vertices: Vec<[f32; 3]>,
    /// The three vertices of each face.
    pub faces: Vec<[usize; 3]>,
    /// The direction to the outside.
    outwards: Point,
    /// The unit of the coordinates.
    size: f64,
}

/// Two directions that are perpendicular to each other and to a third, so that the three are right-handed.
struct Frame {
    along: Point,
    across: Point,
    outwards: Point,
}

impl Frame {
    fn draw(rng: &mut ChaCha8Rng) -> Self {
        // An axis is as good as any direction, and gives coordinates that are equal.
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let (outwards, other) = if rng.random_range(0..4) == 0 {
            let first = rng.random_range(0..3);
            (axes[first], axes[(first + 1) % 3])
        } else {
            (random_unit(rng), random_unit(rng))
        };
        let along = unit(cross(other, outwards));
        Self { along, across: cross(outwards, along), outwards }
    }
}

impl Patch {
    /// A patch of unit size that is seen from above.
    pub fn new(target: Target, vertices: Vec<[f32; 3]>, faces: Vec<[usize; 3]>) -> Self {
        Self { target, vertices, faces, outwards: [0.0, 0.0, 1.0], size: 1.0 }
    }

    /// A random patch: flat, bent or pointed, of faces that are wide or thin as needles, near the origin or far from
    /// it, small or large. One in three has small integers as coordinates in its unit.
    pub fn draw(rng: &mut ChaCha8Rng) -> Self {
        let (frame, size) = (Frame::draw(rng), f64::from(rng.random_range(-10..13)).exp2());
        let is_far = rng.random_range(0..3) == 0;
        let centre: Point =
            std::array::from_fn(|_| if is_far { size * rng.random_range(-100.0..100.0_f64).round() } else { 0.0 });
        // The shares of the unit along the frame's directions.
        let mut share = || [1.0, 1.0, 1.0 / 16.0, 1.0 / 1024.0][rng.random_range(0..4)];
        let shares = [share(), share(), share()];
        let is_lattice = rng.random_range(0..3) == 0;
        let at = |[x, y, z]: Point| -> [f32; 3] {
            let directions =
                [(frame.along, x * shares[0]), (frame.across, y * shares[1]), (frame.outwards, z * shares[2])];
            let point = directions.into_iter().fold([0.0; 3], |at, (direction, x)| sum(at, scaled(direction, x)));
            let grid = if is_lattice { 8.0 } else { f64::from(1 << 28) };
            std::array::from_fn(|i| (centre[i] + size * (point[i] * grid).round() / grid) as f32)
        };
        let mut number = |least: f64| rng.random_range(least..1.0_f64);
        let (target, points, faces) = if number(0.0) < 0.5 {
            let ends = [[-number(0.1), 0.0, number(-1.0)], [number(0.1), 0.0, number(-1.0)]];
            let sides = [[number(-1.0), number(0.1), number(-1.0)], [number(-1.0), -number(0.1), number(-1.0)]];
            (Target::Edge, [ends, sides].concat(), vec![[0, 1, 2], [1, 0, 3]])
        } else {
            let count = 3 + (number(0.0) * 6.0) as usize;
            let step = std::f64::consts::TAU / count as f64;
            let mut points = vec![[0.0, 0.0, number(-1.0)]];
            points.extend((0..count).map(|i| {
                let (angle, radius) = ((i as f64 + number(0.0)) * step, number(0.1));
                [radius * angle.cos(), radius * angle.sin(), number(-1.0)]
            }));
            (Target::Vertex, points, (0..count).map(|i| [0, 1 + i, 1 + (i + 1) % count]).collect())
        };
        let vertices = points.into_iter().map(at).collect();
        Self { outwards: frame.outwards, size, ..Self::new(target, vertices, faces) }
    }

    /// The corners of a face.
    pub fn corners(&self, face: [usize; 3]) -> [[f32; 3]; 3] {
        face.map(|vertex| self.vertices[vertex])
    }

    /// The directed edges that only one face has.
    pub fn rim(&self) -> Vec<[usize; 2]> {
        let edges: Vec<[usize; 2]> = self.faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        edges.iter().copied().filter(|&[a, b]| !edges.contains(&[b, a])).collect()
    }

    /// A ray at the shared edge or vertex, from near or far, from a random side around the outside. One in three has a
    /// direction of small integers, so that it can pass exactly through the target. Half of the others are moved by one
    /// or two ulps. None if the direction is zero.
    pub fn aim(&self, rng: &mut ChaCha8Rng) -> Option<Ray<Binary32>> {
        let [a, b] = [0, 1].map(|vertex: usize| self.vertices[vertex].map(f64::from));
        let target = match self.target {
            Target::Edge => sum(a, scaled(minus(b, a), fraction(rng))),
            Target::Vertex => a,
        };
        let tilt = [0.0, 0.2, 0.5, 1.0, 3.0][rng.random_range(0..5)];
        let backwards = sum(self.outwards, scaled(random_unit(rng), tilt));
        let (backwards, distance) = if rng.random_range(0..3) == 0 {
            let greatest = backwards.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
            let power = f64::from(rng.random_range(-3..6)).exp2();
            (backwards.map(|x| (x / greatest * 4.0).round()), self.size * power)
        } else {
            (backwards, self.size * rng.random_range(-4.0..7.0_f64).exp2())
        };
        let origin = sum(target, scaled(backwards, distance)).map(|x| x as f32);
        let length = [1.0, 1.0, 1.0 / 1024.0, 4096.0][rng.random_range(0..4)] / self.size;
        let towards = minus(target, origin.map(f64::from)).map(|x| (x * length) as f32);
        let is_moved = rng.random();
        let direction =
            towards.map(|x| if is_moved && x != 0.0 { offset_by_ulps(x, rng.random_range(-2..=2)) } else { x });
        Ray::new(origin, direction, f32::INFINITY).ok()
    }
}

fn random_unit(rng: &mut ChaCha8Rng) -> Point {
    loop {
        let point = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
        if (0.01..1.0).contains(&dot(point, point)) {
            return unit(point);
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
