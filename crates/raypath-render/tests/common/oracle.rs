//! The oracle of hits: exact geometry by brute force over all triangles, and the hits that rounding errors allow.
//!
//! The bounds are those of `docs/reference/error-bounds.md`, in binary64, whose own error is 2⁻²⁹ of them; hence the
//! 1.001.

use raypath_ops::{Binary32, Ray};
use raypath_render::{Hit, Mesh};
use raypath_verify_datapath::geometry::visibility::exactly_towards;
use std::cmp::Ordering;

const U: f64 = 1.001 / (1_u64 << 24) as f64;

/// The relation of a hit to exact geometry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Equal: a miss without an exact hit, or one of the nearest triangles.
    Same,
    /// Another triangle than the nearest, within the error bounds.
    Other,
    /// A hit without an exact hit, within the error bounds.
    HitNotMiss,
    /// A miss despite an exact hit, within the error bounds.
    MissNotHit,
}

/// The triangles of a mesh in groups with bounding spheres, which exclude most rays.
pub struct Oracle<'m> {
    mesh: &'m Mesh,
    groups: Vec<Group>,
    two_sided: bool,
}

struct Group {
    triangles: Vec<u32>,
    centre: [f64; 3],
    radius: f64,
}

/// A triangle that a ray may hit.
struct Candidate {
    index: u32,
    /// Whether the exact ray passes through the triangle.
    exact: bool,
    /// Whether the triangle is hit despite any rounding error.
    certain: bool,
    /// The exact distance, if `exact`.
    t: f64,
    /// The bounds of the computed distance of a hit.
    least: f64,
    greatest: f64,
}

impl<'m> Oracle<'m> {
    pub fn new(mesh: &'m Mesh, two_sided: bool) -> Self {
        // Sort along a Morton curve, for small spheres.
        let bounds = mesh.bounds();
        let spread = |x: u32| (0..7).fold(0, |code, bit| code | (x >> bit & 1) << (3 * bit));
        let cell = |index: u32| {
            let [a, b, c] = mesh.corners(index);
            let code = |k: usize| {
                let side = (bounds.max[k] - bounds.min[k]).max(f32::MIN_POSITIVE);
                let part = ((a[k] + b[k] + c[k]) / 3.0 - bounds.min[k]) / side;
                spread((part * 128.0).clamp(0.0, 127.0) as u32)
            };
            code(0) << 2 | code(1) << 1 | code(2)
        };
        let mut order: Vec<u32> = (0..mesh.triangles().len() as u32).collect();
        order.sort_by_key(|&index| cell(index));
        let groups = order.chunks(24).map(|triangles| Group::new(mesh, triangles.to_vec())).collect();
        Self { mesh, groups, two_sided }
    }

    /// Compares a hit with exact geometry. The error describes a hit outside the error bounds.
    pub fn check(&self, ray: &Ray<Binary32>, hit: Option<Hit>) -> Result<Verdict, String> {
        let extent = f64::from(f32::from(ray.extent));
        let candidates = self.candidates(ray);
        let nearest = candidates.iter().filter(|c| c.exact && c.t <= extent).map(|c| c.t).fold(f64::INFINITY, f64::min);
        let Some(hit) = hit else {
            if let Some(missed) = candidates.iter().find(|c| c.certain && c.greatest <= extent) {
                return Err(format!(
                    "a miss, but triangle {} is certainly hit, at {} at most",
                    missed.index, missed.greatest
                ));
            }
            return Ok(if nearest.is_finite() { Verdict::MissNotHit } else { Verdict::Same });
        };
        let t = f64::from(hit.t);
        let Some(found) = candidates.iter().find(|c| c.index == hit.triangle) else {
            return Err(format!("{hit:?}, but the ray misses that triangle"));
        };
        if !(found.least <= t && t <= found.greatest) {
            return Err(format!("{hit:?}, expected a distance from {} to {}", found.least, found.greatest));
        }
        if t > extent {
            return Err(format!("{hit:?} beyond the extent of {extent}"));
        }
        if let Some(nearer) = candidates.iter().find(|c| c.certain && c.greatest < t) {
            return Err(format!(
                "{hit:?}, but triangle {} is certainly nearer, at {} at most",
                nearer.index, nearer.greatest
            ));
        }
        Ok(match nearest {
            _ if found.exact && found.t <= nearest * (1.0 + 1e-12) => Verdict::Same,
            f64::INFINITY => Verdict::HitNotMiss,
            _ => Verdict::Other,
        })
    }

    fn candidates(&self, ray: &Ray<Binary32>) -> Vec<Candidate> {
        let view = View::new(ray);
        let groups = self.groups.iter().filter(|group| view.may_reach(group));
        let mut candidates = Vec::new();
        for &index in groups.flat_map(|group| &group.triangles) {
            let [a, b, c] = self.mesh.corners(index);
            candidates.extend(view.candidate(index, [a, b, c]));
            if self.two_sided {
                candidates.extend(view.candidate(index, [a, c, b]));
            }
        }
        candidates
    }
}

impl Group {
    fn new(mesh: &Mesh, triangles: Vec<u32>) -> Self {
        let corners: Vec<[f64; 3]> =
            triangles.iter().flat_map(|&i| mesh.corners(i)).map(|c| c.map(f64::from)).collect();
        let centre = std::array::from_fn(|k| corners.iter().map(|c| c[k]).sum::<f64>() / corners.len() as f64);
        let distance = |c: &[f64; 3]| (0..3).map(|k| (c[k] - centre[k]).powi(2)).sum::<f64>().sqrt();
        let radius = corners.iter().map(distance).fold(0.0, f64::max);
        Self { triangles, centre, radius }
    }
}

/// The exact ray, in coordinates along its greatest axis.
struct View {
    o32: [f32; 3],
    d32: [f32; 3],
    o: [f64; 3],
    d: [f64; 3],
    k: [usize; 3],
    sx: f64,
    sy: f64,
}

/// A vertex in the coordinates of the ray, with the magnitudes that bound its rounding errors.
#[derive(Clone, Copy)]
struct Seen {
    x: f64,
    y: f64,
    z: f64,
    mx: f64,
    my: f64,
}

impl View {
    fn new(ray: &Ray<Binary32>) -> Self {
        let (o32, d32): ([f32; 3], [f32; 3]) = (ray.origin.into(), ray.dir.into());
        let (o, d) = (o32.map(f64::from), d32.map(f64::from));
        let kz = (0..3).rev().max_by(|&i, &j| d[i].abs().total_cmp(&d[j].abs())).unwrap();
        let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
        let k = if d[kz] < 0.0 { [ky, kx, kz] } else { [kx, ky, kz] };
        Self { o32, d32, o, d, k, sx: d[k[0]] / d[kz], sy: d[k[1]] / d[kz] }
    }

    /// Whether the line passes near the bounding sphere, with a tolerance far above rounding errors.
    fn may_reach(&self, group: &Group) -> bool {
        let r: [f64; 3] = std::array::from_fn(|k| group.centre[k] - self.o[k]);
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (rr, rd, dd) = (dot(r, r), dot(r, self.d), dot(self.d, self.d));
        let radius = group.radius + 1e-4 * (rr.sqrt() + group.radius);
        rr - rd * rd / dd <= radius * radius
    }

    fn see(&self, p: [f32; 3]) -> Seen {
        let [kx, ky, kz] = self.k;
        let r: [f64; 3] = std::array::from_fn(|k| f64::from(p[k]) - self.o[k]);
        let (ax, ay) = (self.sx * r[kz], self.sy * r[kz]);
        Seen {
            x: r[kx] - ax,
            y: r[ky] - ay,
            z: r[kz] / self.d[kz],
            mx: r[kx].abs() + ax.abs(),
            my: r[ky].abs() + ay.abs(),
        }
    }

    /// The candidate for a triangle whose front the ray may hit.
    fn candidate(&self, index: u32, corners: [[f32; 3]; 3]) -> Option<Candidate> {
        let seen = corners.map(|p| self.see(p));
        let (mut edges, mut magnitudes) = ([0.0; 3], [0.0; 3]);
        for i in 0..3 {
            // Edge function U is opposite vertex A: from C to B.
            let (p, q) = (seen[(i + 2) % 3], seen[(i + 1) % 3]);
            edges[i] = p.x * q.y - p.y * q.x;
            magnitudes[i] = p.mx * q.my + p.my * q.mx;
            if edges[i] < -10.0 * U * magnitudes[i] {
                return None;
            }
        }
        let depths = seen.map(|p| p.z);
        let (low, high) =
            (depths.iter().copied().fold(f64::INFINITY, f64::min), depths.iter().copied().fold(0.0, f64::max));
        if high <= 0.0 {
            return None;
        }
        let sum: f64 = edges.iter().sum();
        let magnitude: f64 = magnitudes.iter().sum();
        let signs: [Ordering; 3] = std::array::from_fn(|i| {
            if edges[i].abs() > 1e-13 * magnitudes[i] {
                return edges[i].total_cmp(&0.0);
            }
            exactly_towards(self.d32, [self.o32, corners[(i + 1) % 3], corners[(i + 2) % 3]]).sign()
        });
        let t = (0..3).map(|i| edges[i] * depths[i]).sum::<f64>() / sum;
        let exact = signs.iter().all(|sign| sign.is_ge()) && signs.iter().any(|sign| sign.is_gt()) && t > 0.0;
        let in_front = low > 0.0;
        let certain = in_front && (0..3).all(|i| edges[i] > 10.0 * U * magnitudes[i]);
        // With a vertex behind the origin the terms of the mean have both signs, and 19 roundings scale with the
        // greatest.
        let slack = 19.0 * U * depths.iter().fold(0.0, |max: f64, z| max.max(z.abs()));
        let (mut least, mut greatest) = (low - slack, high + slack);
        let denominator = sum - 12.0 * U * magnitude;
        if exact && denominator > 0.0 {
            let spread = depths.iter().map(|z| (z - t).abs()).fold(0.0, f64::max);
            let bound = slack + 11.0 * U * magnitude / denominator * spread;
            (least, greatest) = (least.max(t - bound), greatest.min(t + bound));
        }
        Some(Candidate { index, exact, certain, t, least, greatest })
    }
}
