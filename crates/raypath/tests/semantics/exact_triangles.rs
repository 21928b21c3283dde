//! Triangles in exact arithmetic: if no operation rounds, the outcome is that of geometry. The oracle uses the
//! formulation of Möller and Trumbore instead of the datapath's.

use crate::semantics::answers::{INF, answers, ray};
use crate::semantics::exact::{Exact, Rational, rational, to_f32};
use crate::semantics::random::rng;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use raypath::ops::{Job, Outcome, RayTriangleInput, Rules, Triangle};
use std::collections::BTreeMap;

type Vector = [Rational; 3];

#[derive(Debug, Clone, Copy)]
struct Case {
    origin: [f32; 3],
    direction: [f32; 3],
    vertices: [[f32; 3]; 3],
}

fn minus(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|i| a[i] - b[i])
}

fn dot(a: Vector, b: Vector) -> Rational {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
}

/// The position of the ray's line relative to the triangle.
struct Geometry {
    /// Twice the projected area along the ray, in units of the greatest direction component; negative from behind.
    area: Rational,
    /// The distance of the triangle's plane along the line, times `area`.
    area_times_t: Rational,
    /// The barycentric coordinates times the determinant, whose sign is that of `area`.
    scaled_barycentric: [Rational; 3],
}

impl Geometry {
    fn of(case: &Case) -> Self {
        let [a, b, c] = case.vertices.map(|v| v.map(rational));
        let (origin, d) = (case.origin.map(rational), case.direction.map(rational));
        let (e1, e2, from_a) = (minus(b, a), minus(c, a), minus(origin, a));
        let (p, q) = (cross(d, e2), cross(from_a, e1));
        let determinant = dot(e1, p);
        let (v, w) = (dot(from_a, p), dot(d, q));
        let greatest = case.direction.into_iter().map(f32::abs).fold(0.0, f32::max);
        Self {
            area: determinant / rational(greatest),
            area_times_t: dot(e2, q) / rational(greatest),
            scaled_barycentric: [determinant - v - w, v, w],
        }
    }

    /// In front of the origin, from the front, in the closed triangle.
    fn is_hit(&self) -> bool {
        let zero = rational(0.0);
        self.area > zero && self.area_times_t > zero && self.scaled_barycentric.iter().all(|&x| x >= zero)
    }

    fn class(&self) -> &'static str {
        let zero = rational(0.0);
        match self.scaled_barycentric.iter().filter(|&&x| x == zero).count() {
            _ if self.area == zero => "flat",
            _ if self.area < zero => "back",
            _ if self.scaled_barycentric.iter().any(|&x| x < zero) => "outside",
            _ if self.area_times_t < zero => "behind",
            _ if self.area_times_t == zero => "at the origin",
            2 => "vertex",
            1 => "edge",
            _ => "inside",
        }
    }
}

/// Whether Table VII computes this case without rounding.
fn is_exact(case: &Case) -> bool {
    let (origin, d) = (case.origin.map(Exact::from), case.direction);
    let input = ray(case.origin, d, INF);
    let [kx, ky, kz] = [input.kx, input.ky, input.kz].map(|k| u32::from(k) as usize);
    let shear = [d[kx], d[ky], 1.0].map(|x| rational(x) / rational(d[kz]));
    let Some([sx, sy, sz]) = shear.map(to_f32).iter().copied().collect::<Option<Vec<_>>>().map(|s| [s[0], s[1], s[2]])
    else {
        return false;
    };
    let [a, b, c] = case.vertices.map(|v| {
        let p: [Exact; 3] = std::array::from_fn(|i| Exact::from(v[i]) - origin[i]);
        [p[kx] - Exact::from(sx) * p[kz], p[ky] - Exact::from(sy) * p[kz], Exact::from(sz) * p[kz]]
    });
    let (u, v, w) = (c[0] * b[1] - c[1] * b[0], a[0] * c[1] - a[1] * c[0], b[0] * a[1] - b[1] * a[0]);
    (u + v + w).all_exact && (u * a[2] + v * b[2] + w * c[2]).all_exact
}

/// A ray at a point of the triangle's plane that is a mean of its vertices with small weights, some negative. Many such
/// points are on edges and vertices, inside and just outside.
fn random_case(rng: &mut ChaCha8Rng) -> Case {
    let kz = rng.random_range(0..3);
    let greatest = [1.0, 2.0, 4.0][rng.random_range(0..3)];
    let mut direction: [f32; 3] = std::array::from_fn(|_| {
        let steps = rng.random_range(-2..=2) as f32;
        steps * greatest / 2.0
    });
    direction[kz] = if rng.random() { greatest } else { -greatest };
    let vertices: [[f32; 3]; 3] = std::array::from_fn(|_| std::array::from_fn(|_| rng.random_range(-3..=3) as f32));
    let (i, j) = (rng.random_range(-1..=3), rng.random_range(-1..=3));
    let weights = [i, j, 4 - i - j].map(|weight| weight as f32 / 4.0);
    let before = rng.random_range(-1..=4) as f32 / 2.0;
    let origin = std::array::from_fn(|axis| {
        let point: f32 = (0..3).map(|v| weights[v] * vertices[v][axis]).sum();
        point - before * direction[axis]
    });
    Case { origin, direction, vertices }
}

#[test]
fn triangles_are_hit_where_geometry_says_so() {
    let mut rng = rng(3);
    let drawn: Vec<Case> = (0..20_000).map(|_| random_case(&mut rng)).collect();
    let cases: Vec<Case> = drawn.iter().copied().filter(is_exact).collect();
    assert!(cases.len() > 15_000, "{} of {} are exact", cases.len(), drawn.len());
    let jobs: Vec<Job> = cases
        .iter()
        .map(|case| {
            let [a, b, c] = case.vertices;
            let ray = ray(case.origin, case.direction, INF);
            Job::Triangle(RayTriangleInput { ray, triangle: Triangle::new(a, b, c) })
        })
        .collect();
    let mut seen = BTreeMap::new();
    for (case, outcome) in cases.iter().zip(answers(Rules::Paper, &jobs)) {
        let Outcome::Triangle(outcome) = outcome else { unreachable!() };
        let geometry = Geometry::of(case);
        assert_eq!(rational(outcome.t_denom.into()), geometry.area, "t_denom of {case:?}");
        assert_eq!(rational(outcome.t_num.into()), geometry.area_times_t, "t_num of {case:?}");
        assert_eq!(bool::from(outcome.triangle_hit), geometry.is_hit(), "{case:?}");
        *seen.entry(geometry.class()).or_insert(0) += 1;
    }
    assert!(seen.len() == 8 && seen.values().all(|&count| count > 200), "{seen:?}");
}
