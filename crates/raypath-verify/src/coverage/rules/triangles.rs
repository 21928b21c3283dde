//! The rules of the ray-triangle operation.

use super::rounded::{Rounded, Rule, fields};
use crate::layout::{Field, Layout};
use raypath_ops::JobKind;

/// What a ray and a triangle can exercise.
pub fn triangle_rules(rounded: Rounded, layout: &Layout, words: &[u64]) -> [Rule; 19] {
    let (mut origin, mut shear, mut axes, mut vertices) = ([0.0; 3], [0.0; 3], [0; 3], [[0.0; 3]; 3]);
    for (field, code) in fields(layout, JobKind::Triangle, words) {
        match field {
            Field::Origin(axis) => origin[axis] = rounded.value(code),
            Field::Shear(axis) => shear[axis] = rounded.value(code),
            Field::Axis(axis) => axes[axis] = code as usize & 3,
            Field::Vertex { vertex, axis } => vertices[vertex][axis] = rounded.value(code),
            _ => {}
        }
    }
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
    [
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
    ]
}
