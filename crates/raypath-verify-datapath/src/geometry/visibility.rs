//! The preconditions of `docs/reference/error-bounds.md` on a ray and a patch, decided without rounding errors.

use super::patches::Patch;
use super::vector::{Point, cross, dot, minus};
use raypath_ops::{Binary32, Ray};
use raypath_oracle::geometry::dyadic::{Dyadic, U};

/// The position of a ray relative to a patch of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Visibility {
    /// A face of the patch does not face the ray.
    BackFacing,
    /// A vertex of the patch is not in front of the ray's origin.
    Behind,
    /// The ray misses the patch, or passes its rim at a distance within the rounding error of vertices.
    NearRim,
    /// The ray passes through the patch, but the projection of a face is so thin that rounding may close it.
    Thin,
    /// The ray passes through the patch, and no face is thin: the ray must hit a face. The patch winds around the ray
    /// this number of times.
    Clear(usize),
}

/// A factor for terms of second order and for rounding errors of this computation in binary64.
const SAFETY: f64 = 1.001;

/// The position of this ray relative to this patch.
pub fn visibility(ray: &Ray<Binary32>, patch: &Patch) -> Visibility {
    if !patch.faces.iter().all(|&face| faces_direction(ray.dir.into(), patch.corners(face))) {
        return Visibility::BackFacing;
    }
    let projection = Projection::new(ray);
    let projected: Vec<Projected> = patch.vertices.iter().map(|vertex| projection.project(*vertex)).collect();
    let mut moved: f64 = 0.0;
    for projected in &projected {
        if projected.depth <= 0.0 {
            return Visibility::Behind;
        }
        moved = moved.max(projected.moved);
    }
    let at = |vertex: usize| projected[vertex].at;
    let rim = patch.rim();
    let rim = || rim.iter().map(|edge| edge.map(at));
    let turns = rim().map(turns).sum::<i32>();
    if rim().any(|edge| distance_from_zero(edge) <= moved) || turns < 1 {
        return Visibility::NearRim;
    }
    let is_thin = |face: &[usize; 3]| is_thin(face.map(at), moved);
    if patch.faces.iter().any(is_thin) { Visibility::Thin } else { Visibility::Clear(turns as usize) }
}

/// Whether a face, counter-clockwise as seen from outside, faces rays of this direction. Computed in binary64 if its
/// error bound allows, else exactly.
pub fn faces_direction(direction: [f32; 3], corners: [[f32; 3]; 3]) -> bool {
    let [a, b, c] = corners.map(|corner| corner.map(f64::from));
    let d = direction.map(f64::from);
    let (e, f) = (minus(b, a), minus(c, a));
    let towards = dot(d, cross(e, f));
    let magnitude: f64 = (0..3)
        .map(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            d[i].abs() * ((e[j] * f[k]).abs() + (e[k] * f[j]).abs())
        })
        .sum();
    // Each term has at most eight roundings.
    let error = magnitude * 2_f64.powi(-49);
    if towards.abs() > error { towards < 0.0 } else { exactly_towards(direction, corners).sign().is_lt() }
}

/// direction · ((b − a) × (c − a))
pub fn exactly_towards(direction: [f32; 3], corners: [[f32; 3]; 3]) -> Dyadic {
    let [a, b, c] = corners.map(|corner| corner.map(Dyadic::from));
    let e: [Dyadic; 3] = std::array::from_fn(|i| &b[i] - &a[i]);
    let f: [Dyadic; 3] = std::array::from_fn(|i| &c[i] - &a[i]);
    (0..3).fold(Dyadic::default(), |sum, i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        sum + Dyadic::from(direction[i]) * (&e[j] * &f[k] - &e[k] * &f[j])
    })
}

/// The projection along the ray that the datapath computes by shearing; the ray is its origin. It is mirrored, because
/// the datapath's projection shows a face that faces the ray clockwise.
struct Projection {
    origin: Point,
    axes: [usize; 3],
    slope: [f64; 2],
    forward: f64,
}

struct Projected {
    at: [f64; 2],
    /// The distance along kz, in units of the direction's length.
    depth: f64,
    /// The bound of its rounding error: γ₄ times the magnitudes of the operands of its differences.
    moved: f64,
}

impl Projection {
    fn new(ray: &Ray<Binary32>) -> Self {
        let axes = [ray.kx, ray.ky, ray.kz].map(|k| u32::from(k) as usize);
        let d = <[f32; 3]>::from(ray.dir).map(f64::from);
        let slope = [d[axes[0]] / d[axes[2]], d[axes[1]] / d[axes[2]]];
        Self { origin: <[f32; 3]>::from(ray.origin).map(f64::from), axes, slope, forward: d[axes[2]] }
    }

    fn project(&self, vertex: [f32; 3]) -> Projected {
        let relative = minus(vertex.map(f64::from), self.origin);
        let [x, y, z] = self.axes.map(|axis| relative[axis]);
        let shift = self.slope.map(|slope| slope * z);
        let (reach_x, reach_y) = (x.abs() + shift[0].abs(), y.abs() + shift[1].abs());
        let moved = 4.0 * U * SAFETY * reach_x.hypot(reach_y);
        Projected { at: [y - shift[1], x - shift[0]], depth: z / self.forward, moved }
    }
}

fn distance_from_zero([a, b]: [[f64; 2]; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let length = along[0] * along[0] + along[1] * along[1];
    let nearest = if length == 0.0 { 0.0 } else { (-(a[0] * along[0] + a[1] * along[1]) / length).clamp(0.0, 1.0) };
    (a[0] + nearest * along[0]).hypot(a[1] + nearest * along[1])
}

/// The edge's signed crossings of the positive x axis; their sum over a closed curve is its winding number around zero.
fn turns([a, b]: [[f64; 2]; 2]) -> i32 {
    let is_right_of_zero = |sense: f64| (a[0] * b[1] - a[1] * b[0]) * sense > 0.0;
    match (a[1] >= 0.0, b[1] >= 0.0) {
        (false, true) if is_right_of_zero(1.0) => 1,
        (true, false) if is_right_of_zero(-1.0) => -1,
        _ => 0,
    }
}

/// Whether a face may close, or its three edge functions may cancel, when its vertices move this far.
fn is_thin([a, b, c]: [[f64; 2]; 3], moved: f64) -> bool {
    let minus = |p: [f64; 2], q: [f64; 2]| [p[0] - q[0], p[1] - q[1]];
    let (e, f, g) = (minus(b, a), minus(c, a), minus(c, b));
    let length = [e, f, g].map(|[x, y]| x.hypot(y)).into_iter().fold(0.0, f64::max);
    let twice_area = e[0] * f[1] - e[1] * f[0];
    let lost = 4.0 * moved * length + 4.0 * moved * moved + 3.0 * U * (length + 2.0 * moved).powi(2);
    twice_area <= SAFETY * lost
}

#[cfg(test)]
mod tests {
    use super::super::patches::{Patch, Target};
    use super::{Visibility, distance_from_zero, exactly_towards, faces_direction, turns, visibility};
    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};
    use raypath_ops::Ray;

    /// Faces nearly edge-on, which need exact arithmetic.
    #[test]
    fn orientation_is_exact() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut edge_on = 0;
        for _ in 0..2000 {
            let mut point = || -> [f32; 3] { std::array::from_fn(|_| rng.random_range(-8..8) as f32 / 4.0) };
            let corners @ [a, b, c] = [point(), point(), point()];
            let (i, j, tiny) = (rng.random_range(-2..3), rng.random_range(-2..3), rng.random_range(-1..2));
            let mut direction: [f32; 3] = std::array::from_fn(|k| i as f32 * (b[k] - a[k]) + j as f32 * (c[k] - a[k]));
            direction[0] += tiny as f32 * f32::from_bits(1);
            let towards = exactly_towards(direction, corners);
            assert_eq!(faces_direction(direction, corners), towards.sign().is_lt());
            edge_on += usize::from(towards.to_f64().abs() < 1e-30);
        }
        assert!(edge_on > 1500);
        assert!(faces_direction([0.0, 0.0, -1.0], [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]));
        assert!(!faces_direction([0.0, 0.0, 1.0], [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]));
        assert!(!faces_direction([1.0, 1.0, 0.0], [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]));
    }

    #[test]
    fn curves_wind_around_what_is_inside() {
        let around = |x: f64, y: f64| {
            let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[a, b]| [a - x, b - y]);
            (0..4).map(|i| turns([corners[i], corners[(i + 1) % 4]])).sum::<i32>()
        };
        assert_eq!(
            (around(0.0, 0.0), around(0.9, -0.9), around(0.0, 1.1), around(1.1, 0.0), around(-3.0, 1.0)),
            (1, 1, 0, 0, 0)
        );
        assert_eq!(distance_from_zero([[3.0, 4.0], [6.0, 8.0]]), 5.0);
        assert_eq!(distance_from_zero([[3.0, -4.0], [3.0, 4.0]]), 3.0);
    }

    /// A square of two faces in the plane z = 0, seen from above.
    #[test]
    fn each_visibility_occurs() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let patch = Patch::new(Target::Edge, points.to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
        let see = |origin, direction| visibility(&Ray::new(origin, direction, 1.0).expect("a ray"), &patch);
        assert_eq!(see([0.5, 0.5, 2.0], [0.0, 0.0, -1.0]), Visibility::Clear(1));
        assert_eq!(see([0.5, 0.5, 2.0], [0.0, 0.0, 1.0]), Visibility::BackFacing);
        assert_eq!(see([0.5, 0.5, -2.0], [0.0, 0.0, -1.0]), Visibility::Behind);
        assert_eq!(see([0.5, 1e-8, 2.0], [0.0, 0.0, -1.0]), Visibility::NearRim);
        assert_eq!(see([0.5, 1.5, 2.0], [0.0, 0.0, -1.0]), Visibility::NearRim);
        assert_eq!(see([0.5, 1e-6, 2.0], [0.0, 0.0, -1.0]), Visibility::Clear(1));
        let thin = points.map(|[x, y, _]| [x, y * 0.4e-6, 0.0]).to_vec();
        let flat = Patch::new(Target::Edge, thin, patch.faces.clone());
        let ray = Ray::new([0.5, 0.2e-6, 2.0], [0.0, 0.0, -1.0], 1.0).expect("a ray");
        assert_eq!(visibility(&ray, &flat), Visibility::Thin);
    }
}
