//! A ray against a triangle, by Table VII, rulings 6 and 8 of `docs/reference/semantics.md`, and its sections on faces
//! and the range.

use super::inputs::Inputs;
use super::mistake::Mistake;
use super::number::{Arithmetic, Number};
use raypath_ops::{Culling, Rounding, Rules};
use raypath_rtl::Semantics;
use std::cmp::Ordering;

/// The answer for a triangle.
pub struct Triangle {
    /// U, V and W.
    pub edges: [Number; 3],
    pub t_num: Number,
    pub t_denom: Number,
    pub is_hit: bool,
    /// Whether the ray meets the front face.
    pub is_front: bool,
}

impl Triangle {
    pub fn of(arithmetic: &Arithmetic, semantics: Semantics, inputs: &Inputs) -> Self {
        let (sub, mul) = (|a: &_, b: &_| arithmetic.sub(a, b), |a: &_, b: &_| arithmetic.mul(a, b));
        let [kx, ky, kz] = inputs.axes;
        let [sx, sy, sz] = &inputs.shear;
        let [a, b, c] = inputs.vertices.each_ref().map(|vertex| {
            let [x, y, z] = [kx, ky, kz].map(|axis| sub(&vertex[axis], &inputs.origin[axis]));
            [sub(&x, &mul(sx, &z)), sub(&y, &mul(sy, &z)), mul(sz, &z)]
        });
        let edge = |p: &[Number; 3], q: &[Number; 3]| sub(&mul(&p[0], &q[1]), &mul(&p[1], &q[0]));
        let edges = [edge(&c, &b), edge(&a, &c), edge(&b, &a)];
        let [u, v, w] = &edges;
        let depths = [mul(u, &a[2]), mul(v, &b[2]), mul(w, &c[2])];
        let total = |[x, y, z]: &[Number; 3]| match semantics.rounding {
            Rounding::Unit if arithmetic.makes(Mistake::OtherOrder) => arithmetic.add(x, &arithmetic.add(y, z)),
            Rounding::Unit => arithmetic.add(&arithmetic.add(x, y), z),
            Rounding::Sum => arithmetic.sum(&[x.clone(), y.clone(), z.clone()]),
        };
        let (t_denom, t_num) = (total(&edges), total(&depths));
        let is_front = t_denom.is_above_zero();
        let mut triangle = Self { edges, t_num, t_denom, is_hit: false, is_front };
        triangle.is_hit = triangle.hit(arithmetic, semantics, inputs);
        triangle
    }

    fn hit(&self, arithmetic: &Arithmetic, semantics: Semantics, inputs: &Inputs) -> bool {
        let (rules, features) = (semantics.rules, semantics.features);
        let bounds = features.range.then(|| {
            let product = |bound| arithmetic.mul(bound, &self.t_denom);
            [product(&inputs.t_min), product(&inputs.extent)]
        });
        let back = |number: &Number| number.negated();
        let front = |number: &Number| number.clone();
        let hits = |side: &dyn Fn(&Number) -> Number| {
            let is_hit = self.hits_side(arithmetic, rules, side);
            let is_within = bounds.as_ref().is_none_or(|bounds| self.is_within(arithmetic, rules, bounds, side));
            is_hit && is_within
        };
        match features.culling {
            _ if arithmetic.makes(Mistake::CullingIgnored) => hits(&front) || hits(&back),
            Culling::Back => hits(&front),
            Culling::Front => hits(&back),
            Culling::None => hits(&front) || hits(&back),
        }
    }

    /// Whether a face is hit: `side` inverts the signs for the back.
    fn hits_side(&self, arithmetic: &Arithmetic, rules: Rules, side: &dyn Fn(&Number) -> Number) -> bool {
        let (edges, t_num) = (self.edges.each_ref().map(side), side(&self.t_num));
        match rules {
            Rules::Paper | Rules::Bounds(_) => {
                let is_open = arithmetic.makes(Mistake::OpenEdges);
                let is_inside =
                    edges.iter().all(|edge| if is_open { edge.is_above_zero() } else { edge.is_at_least_zero() });
                is_inside && !self.t_denom.is_zero() && !self.t_denom.is_nan() && t_num.is_above_zero()
            }
            Rules::Chisel => {
                let is_excluded = edges.iter().any(Number::is_below_zero) || t_num.is_below_zero();
                !is_excluded && !self.t_denom.is_zero()
            }
        }
    }

    /// Whether the distance is in the range: t_min · t_denom ≤ t_num ≤ extent · t_denom, reversed for a back face. With
    /// `chisel`, whether no comparison shows that it is not.
    fn is_within(
        &self,
        arithmetic: &Arithmetic,
        rules: Rules,
        [near, far]: &[Number; 2],
        side: &dyn Fn(&Number) -> Number,
    ) -> bool {
        let [near, t_num, far] = [side(near), side(&self.t_num), side(far)];
        let is_open = arithmetic.makes(Mistake::OpenRange);
        let is_right = |order: Option<Ordering>| match (rules, order) {
            (Rules::Chisel, None) => true,
            (_, None) => false,
            (_, Some(order)) => {
                if is_open {
                    order.is_lt()
                } else {
                    order.is_le()
                }
            }
        };
        is_right(near.order(&t_num)) && is_right(t_num.order(&far))
    }
}
