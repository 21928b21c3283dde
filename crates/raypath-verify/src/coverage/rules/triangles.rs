//! The rules of the ray-triangle operation.

use super::declare::{fields, rules};
use super::rounded::Rounded;
use crate::layout::{Field, Layout};
use raypath_ops::JobKind;

rules! {
    /// What a ray and a triangle can exercise.
    TriangleRule {
        Hit = "6: U, V, W, t_denom, t_num > 0",
        OnlyU = "6: U < 0 alone",
        OnlyV = "6: V < 0 alone",
        OnlyW = "6: W < 0 alone",
        Behind = "6: U, V, W < 0, seen from behind",
        EdgeU = "6: U = 0, a hit on the edge",
        EdgeV = "6: V = 0, a hit on the edge",
        EdgeW = "6: W = 0, a hit on the edge",
        Vertex = "6: two of U, V, W = 0, a hit on a vertex",
        MinusZero = "6: one of U, V, W = −0, a hit",
        DenominatorZero = "6: U, V, W ≥ 0, t_denom = 0",
        NumeratorZero = "6: U, V, W ≥ 0, t_num = 0",
        NumeratorNegative = "6: U, V, W ≥ 0, t_num < 0",
        EdgeNan = "6: one of U, V, W = NaN",
        DenominatorNan = "6: t_denom = ∞ − ∞",
        NumeratorNan = "6: U, V, W ≥ 0, t_num = NaN",
        AxisThree = "8: an axis index of 3 reads z",
        AxesRepeat = "8: two axes are the same",
        MissReported = "8: a miss, t_num and t_denom not zero",
    }
}

impl TriangleRule {
    /// Calls `visit` with each rule that a job exercises.
    pub fn each(rounded: Rounded, layout: &Layout, words: &[u64], mut visit: impl FnMut(Self)) {
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
        if axes.contains(&3) {
            visit(Self::AxisThree);
        }
        let [kx, ky, kz] = axes.map(|axis| axis.min(2));
        if kx == ky || ky == kz || kx == kz {
            visit(Self::AxesRepeat);
        }
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
        of_hit([u, v, w], t_denom, t_num, &mut visit);
    }
}

fn of_hit(edges: [f64; 3], t_denom: f64, t_num: f64, visit: &mut impl FnMut(TriangleRule)) {
    let is_inside = edges.iter().all(|edge| *edge >= 0.0);
    let is_hit = is_inside && t_denom > 0.0 && t_num > 0.0;
    if is_hit {
        let zeros = edges.iter().filter(|edge| **edge == 0.0).count();
        for (edge, rule) in edges.iter().zip([TriangleRule::EdgeU, TriangleRule::EdgeV, TriangleRule::EdgeW]) {
            if *edge == 0.0 {
                visit(rule);
            }
        }
        if zeros == 0 {
            visit(TriangleRule::Hit);
        }
        if zeros == 2 {
            visit(TriangleRule::Vertex);
        }
        if edges.iter().any(|edge| *edge == 0.0 && edge.is_sign_negative()) {
            visit(TriangleRule::MinusZero);
        }
    } else if t_denom != 0.0 && t_num != 0.0 {
        visit(TriangleRule::MissReported);
    }
    if is_inside && t_denom == 0.0 {
        visit(TriangleRule::DenominatorZero);
    }
    if is_inside && t_denom > 0.0 && !is_hit {
        visit(match t_num {
            0.0 => TriangleRule::NumeratorZero,
            _ if t_num.is_nan() => TriangleRule::NumeratorNan,
            _ => TriangleRule::NumeratorNegative,
        });
    }
    if edges.iter().any(|edge| edge.is_nan()) {
        visit(TriangleRule::EdgeNan);
    } else if t_denom.is_nan() {
        visit(TriangleRule::DenominatorNan);
    }
    match edges.map(|edge| (edge < 0.0, edge >= 0.0)) {
        [(true, _), (_, true), (_, true)] => visit(TriangleRule::OnlyU),
        [(_, true), (true, _), (_, true)] => visit(TriangleRule::OnlyV),
        [(_, true), (_, true), (true, _)] => visit(TriangleRule::OnlyW),
        [(true, _), (true, _), (true, _)] => visit(TriangleRule::Behind),
        _ => {}
    }
}
