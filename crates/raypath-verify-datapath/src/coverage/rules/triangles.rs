//! The rules of the ray-triangle operation.

use super::job::{Job, Rule, rules as plain};
use crate::layout::Field;
use raypath_ops::Culling;

/// What a ray and a triangle can exercise.
pub fn rules(job: &Job<'_>) -> Vec<Rule> {
    let rounded = job.rounded();
    let (origin, shear) = (job.vector(Field::Origin), job.vector(Field::Shear));
    let axes = [0, 1, 2].map(|axis| job.word(Field::Axis(axis)).unwrap_or(0) as usize & 3);
    let vertex = |vertex| [0, 1, 2].map(|axis| job.number(Field::Vertex { vertex, axis }));
    let vertices = [vertex(0), vertex(1), vertex(2)];
    let [kx, ky, kz] = axes.map(|axis| axis.min(2));
    let (sub, mul, add) = (|a, b| rounded.sub(a, b), |a, b| rounded.mul(a, b), |a, b| rounded.add(a, b));
    let [a, b, c] = vertices.map(|vertex: [f64; 3]| {
        let p: [f64; 3] = std::array::from_fn(|axis| sub(vertex[axis], origin[axis]));
        [sub(p[kx], mul(shear[0], p[kz])), sub(p[ky], mul(shear[1], p[kz])), mul(shear[2], p[kz])]
    });
    let u = sub(mul(c[0], b[1]), mul(c[1], b[0]));
    let v = sub(mul(a[0], c[1]), mul(a[1], c[0]));
    let w = sub(mul(b[0], a[1]), mul(b[1], a[0]));
    let t_denom = add(add(u, v), w);
    let t_num = add(add(mul(u, a[2]), mul(v, b[2])), mul(w, c[2]));

    let edges = [u, v, w];
    let (is_negative, is_inside) = (edges.map(|edge| edge < 0.0), edges.iter().all(|edge| *edge >= 0.0));
    let alone = |i: usize| is_negative[i] && (0..3).all(|other| other == i || edges[other] >= 0.0);
    let zeros = edges.iter().filter(|edge| **edge == 0.0).count();
    let is_before = is_inside && t_denom > 0.0;
    let is_hit = is_before && t_num > 0.0;
    let is_nan = edges.iter().any(|edge| edge.is_nan());
    let mut rules = plain([
        ("6: U, V, W, t_denom, t_num > 0", is_hit && zeros == 0),
        ("6: U < 0 alone", alone(0)),
        ("6: V < 0 alone", alone(1)),
        ("6: W < 0 alone", alone(2)),
        ("6: U, V, W < 0, seen from behind", is_negative == [true; 3]),
        ("6: U = 0, a hit on the edge", is_hit && u == 0.0),
        ("6: V = 0, a hit on the edge", is_hit && v == 0.0),
        ("6: W = 0, a hit on the edge", is_hit && w == 0.0),
        ("6: two of U, V, W = 0, a hit on a vertex", is_hit && zeros == 2),
        ("6: one of U, V, W = −0, a hit", is_hit && edges.iter().any(|edge| *edge == 0.0 && edge.is_sign_negative())),
        ("6: U, V, W ≥ 0, t_denom = 0", is_inside && t_denom == 0.0),
        ("6: U, V, W ≥ 0, t_num = 0", is_before && t_num == 0.0),
        ("6: U, V, W ≥ 0, t_num < 0", is_before && t_num < 0.0),
        ("6: one of U, V, W = NaN", is_nan),
        ("6: t_denom = ∞ − ∞", !is_nan && t_denom.is_nan()),
        ("6: U, V, W ≥ 0, t_num = NaN", is_before && t_num.is_nan()),
        ("8: an axis index of 3 reads z", axes.contains(&3)),
        ("8: two axes are the same", kx == ky || ky == kz || kx == kz),
        ("8: a miss, t_num and t_denom not zero", !is_hit && t_denom != 0.0 && t_num != 0.0),
    ]);
    let features = job.semantics.features;
    let is_behind = edges.iter().all(|edge| *edge <= 0.0) && t_denom < 0.0;
    if features.culling != Culling::Back {
        rules.extend(plain([
            ("faces: a back face is hit", is_behind && t_num < 0.0 && zeros == 0),
            ("faces: a back face is hit on an edge", is_behind && t_num < 0.0 && zeros > 0),
            ("faces: a back face behind the origin", is_behind && t_num > 0.0),
            ("faces: a back face, t_num = 0", is_behind && t_num == 0.0),
            ("faces: a front face is hit", is_hit),
        ]));
    }
    if features.facing {
        rules.extend(plain([
            ("facing: t_denom > 0", t_denom > 0.0),
            ("facing: t_denom < 0", t_denom < 0.0),
            ("facing: t_denom = ±0", t_denom == 0.0),
            ("facing: t_denom is NaN", t_denom.is_nan()),
        ]));
    }
    if features.range {
        let (t_min, extent) = (job.number(Field::TMin), job.number(Field::Extent));
        let (near, far) = (mul(t_min, t_denom), mul(extent, t_denom));
        // The face that is hit without the range: the back one reverses the relations.
        let hits = [is_hit && features.culling != Culling::Front, is_behind && t_num < 0.0];
        let [is_front, is_back] = [hits[0], hits[1] && features.culling != Culling::Back];
        let either = |front: bool, back: bool| is_front && front || is_back && back;
        rules.extend(plain([
            ("range: before t_min", either(near > t_num, near < t_num)),
            ("range: at t_min", (is_front || is_back) && near == t_num),
            ("range: between t_min and extent", either(near < t_num && t_num < far, near > t_num && t_num > far)),
            ("range: at the extent", (is_front || is_back) && t_num == far),
            ("range: beyond the extent", either(t_num > far, t_num < far)),
            ("range: t_min < 0", (is_front || is_back) && t_min < 0.0),
            ("range: t_min is NaN", (is_front || is_back) && t_min.is_nan()),
            ("range: the extent is +∞", (is_front || is_back) && extent == f64::INFINITY),
            ("range: the extent is NaN", (is_front || is_back) && extent.is_nan()),
        ]));
    }
    rules
}
