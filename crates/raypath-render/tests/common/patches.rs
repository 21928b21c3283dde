//! The watertightness theorem of `docs/reference/error-bounds.md`, applied to edges and vertices of meshes.

use super::exact;
use raypath_ops::{Binary32, Ray};
use raypath_render::Mesh;
use std::collections::HashMap;

/// The faces around each edge and vertex.
pub struct Patches<'m> {
    mesh: &'m Mesh,
    /// The faces of each directed edge.
    edges: HashMap<(u32, u32), Vec<u32>>,
    fans: HashMap<u32, Vec<u32>>,
}

impl<'m> Patches<'m> {
    pub fn new(mesh: &'m Mesh) -> Self {
        let (mut edges, mut fans) = (HashMap::new(), HashMap::new());
        for (face, &[a, b, c]) in (0..).zip(mesh.triangles()) {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                edges.entry((from, to)).or_insert_with(Vec::new).push(face);
            }
            for vertex in [a, b, c] {
                fans.entry(vertex).or_insert_with(Vec::new).push(face);
            }
        }
        Self { mesh, edges, fans }
    }

    /// The two faces of an edge of `face`, if there are exactly two with opposite directions.
    pub fn edge(&self, face: u32, corner: usize) -> Option<Vec<u32>> {
        let corners = self.mesh.triangles()[face as usize];
        let (a, b) = (corners[corner], corners[(corner + 1) % 3]);
        let (one, other) = (self.edges.get(&(a, b))?, self.edges.get(&(b, a))?);
        (one.len() == 1 && other.len() == 1 && one != other).then(|| vec![one[0], other[0]])
    }

    /// All faces at a corner of `face`.
    pub fn fan(&self, face: u32, corner: usize) -> Vec<u32> {
        self.fans[&self.mesh.triangles()[face as usize][corner]].clone()
    }

    /// The greatest possible distance of the hit, if the theorem guarantees one: all faces of the patch face the ray
    /// with all vertices in front, no face is thin, and the ray passes farther from the rim than rounding moves a
    /// vertex.
    pub fn must_hit(&self, patch: &[u32], ray: &Ray<Binary32>) -> Option<f64> {
        let (o, d): ([f32; 3], [f32; 3]) = (ray.origin.into(), ray.dir.into());
        let seen = |p: [f32; 3]| project(o, d, p);
        let (mut rho, mut farthest, mut winding) = (0.0_f64, 0.0_f64, false);
        for &face in patch {
            let [a, b, c] = self.mesh.corners(face);
            // d · normal < 0: seen from a point before it on the ray, the corners run counter-clockwise.
            if facing(d, [a, b, c]) >= 0.0 {
                return None;
            }
            for corner in [a, b, c] {
                let (_, depth, error) = seen(corner);
                if depth <= 0.0 {
                    return None;
                }
                (rho, farthest) = (rho.max(error), farthest.max(depth));
            }
            let sides = [exact::side(o, d, a, b), exact::side(o, d, b, c), exact::side(o, d, c, a)];
            winding |= sides.iter().all(|&side| side >= 0) || sides.iter().all(|&side| side <= 0);
        }
        // The theorem excludes thin faces.
        for &face in patch {
            let [a, b, c] = self.mesh.corners(face).map(|p| seen(p).0);
            let area = ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs();
            let longest =
                [(a, b), (b, c), (c, a)].iter().map(|(p, q)| (p[0] - q[0]).hypot(p[1] - q[1])).fold(0.0, f64::max);
            let u = 1.0 / (1_u64 << 24) as f64;
            if area <= 4.0 * rho * longest + 4.0 * rho * rho + 3.0 * u * (longest + 2.0 * rho).powi(2) {
                return None;
            }
        }
        if !winding {
            return None;
        }
        for &face in patch {
            let corners = self.mesh.triangles()[face as usize];
            for k in 0..3 {
                let (p, q) = (corners[k], corners[(k + 1) % 3]);
                let inner =
                    patch.iter().any(|&other| other != face && runs_along(self.mesh.triangles()[other as usize], q, p));
                let [p, q] = [p, q].map(|vertex| seen(self.mesh.positions()[vertex as usize]).0);
                if !inner && distance(p, q) <= 1.001 * rho {
                    return None;
                }
            }
        }
        Some(farthest * (1.0 + 1e-6))
    }
}

fn runs_along([a, b, c]: [u32; 3], from: u32, to: u32) -> bool {
    [(a, b), (b, c), (c, a)].contains(&(from, to))
}

/// d · normal, or 0 if its sign is uncertain in binary64.
fn facing(d: [f32; 3], corners: [[f32; 3]; 3]) -> f64 {
    let [a, b, c] = corners.map(|p| p.map(f64::from));
    let (p, q): ([f64; 3], [f64; 3]) = (std::array::from_fn(|k| b[k] - a[k]), std::array::from_fn(|k| c[k] - a[k]));
    let terms: [[f64; 2]; 3] = std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        [p[i] * q[j] * f64::from(d[k]), p[j] * q[i] * f64::from(d[k])]
    });
    let sum: f64 = terms.iter().map(|[plus, minus]| plus - minus).sum();
    let magnitude: f64 = terms.as_flattened().iter().map(|term| term.abs()).sum();
    if sum.abs() <= 1e-14 * magnitude { 0.0 } else { sum }
}

/// A point in the plane across the greatest axis of the ray, its depth, and its rounding error in that plane.
fn project(o: [f32; 3], d: [f32; 3], p: [f32; 3]) -> ([f64; 2], f64, f64) {
    let kz = (0..3).rev().max_by(|&i, &j| d[i].abs().total_cmp(&d[j].abs())).unwrap();
    let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
    let r: [f64; 3] = std::array::from_fn(|k| f64::from(p[k]) - f64::from(o[k]));
    let depth = r[kz] / f64::from(d[kz]);
    let (ax, ay) = (f64::from(d[kx]) * depth, f64::from(d[ky]) * depth);
    let gamma = 4.0 * 1.001 / (1_u64 << 24) as f64;
    let error = gamma * (r[kx].abs() + ax.abs()).hypot(r[ky].abs() + ay.abs());
    ([r[kx] - ax, r[ky] - ay], depth, error)
}

/// The distance from the origin to the segment between two points.
fn distance(p: [f64; 2], q: [f64; 2]) -> f64 {
    let along = [q[0] - p[0], q[1] - p[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let part = if square > 0.0 { (-(p[0] * along[0] + p[1] * along[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    (p[0] + part * along[0]).hypot(p[1] + part * along[1])
}
