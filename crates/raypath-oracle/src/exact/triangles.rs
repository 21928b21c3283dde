//! A ray against a triangle, by Table VII, rulings 6 and 8 of `docs/reference/semantics.md`, and its sections on faces
//! and the range.

use super::inputs::Inputs;
use super::mistake::Mistake;
use super::number::{Arithmetic, Number};
use raypath_ops::{Culling, EdgeRule, Rounding, Rules};
use raypath_rtl::Semantics;
use std::cmp::Ordering;

/// The answer for a triangle.
#[derive(Debug)]
pub struct Triangle {
    /// To which face the points of each edge belong, `Greater` for the front, if its function is 0 after rounding.
    ties: [Tie; 3],
    /// U, V and W.
    pub edges: [Number; 3],
    pub t_num: Number,
    pub t_denom: Number,
    pub is_hit: bool,
    /// Whether the ray meets the front face.
    pub is_front: bool,
}

/// A face of the triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Face {
    Front,
    Back,
}

impl Face {
    /// The order to zero of what belongs to it.
    fn above(self) -> Ordering {
        if self == Self::Front { Ordering::Greater } else { Ordering::Less }
    }

    /// A number whose sign is that of the front: the back has the opposite.
    fn seen(self, number: Number) -> Number {
        if self == Self::Front { number } else { number.negated() }
    }
}

/// `None`: both faces have the points.
type Tie = Option<Ordering>;

/// By the exact products, or if they are equal by the side of the line y = 0 on which the ends are, or on y = 0 by the sign
/// of x. A product of a magnitude below the normal range decides nothing.
fn tie(arithmetic: &Arithmetic, start: [Number; 3], end: [Number; 3]) -> Tie {
    let products = [[end[0], start[1]], [end[1], start[0]]];
    if products.iter().any(|&factors| arithmetic.is_product_tiny(factors)) {
        return None;
    }
    let half = |[x, y, _]: [Number; 3]| if y.is_zero() { x } else { y }.order(Number::ZERO);
    Some(Arithmetic::order_of_products(products).then(half(end).cmp(&half(start))))
}

impl Triangle {
    pub fn of(arithmetic: &Arithmetic, semantics: Semantics, inputs: &Inputs) -> Self {
        let [kx, ky, kz] = inputs.axes;
        let [sx, sy, sz] = inputs.shear;
        let sheared = inputs.vertices.map(|vertex| {
            let [x, y, z] = [kx, ky, kz].map(|axis| arithmetic.sub(vertex[axis], inputs.origin[axis]));
            let sheared = |x, shear| arithmetic.sub(x, arithmetic.mul(shear, z));
            [sheared(x, sx), sheared(y, sy), arithmetic.mul(sz, z)]
        });
        let [a, b, c] = sheared;
        let edges = [(c, b), (a, c), (b, a)].map(|(p, q)| arithmetic.cross([p[0], q[1]], [p[1], q[0]]));
        let ties = [0, 1, 2].map(|place| tie(arithmetic, sheared[(place + 1) % 3], sheared[(place + 2) % 3]));
        let [u, v, w] = edges;
        let depths = [(u, a), (v, b), (w, c)].map(|(edge, vertex)| arithmetic.mul(edge, vertex[2]));
        let total = |[x, y, z]: [Number; 3]| match semantics.rounding {
            Rounding::Unit if arithmetic.makes(Mistake::OtherOrder) => arithmetic.add(x, arithmetic.add(y, z)),
            Rounding::Unit => arithmetic.add(arithmetic.add(x, y), z),
            Rounding::Sum => arithmetic.sum(&[x, y, z]),
        };
        let (t_denom, t_num) = (total(edges), total(depths));
        let is_front = t_denom.is_above_zero();
        let mut triangle = Self { ties, edges, t_num, t_denom, is_hit: false, is_front };
        triangle.is_hit = triangle.hit(arithmetic, semantics, inputs);
        triangle
    }

    fn hit(&self, arithmetic: &Arithmetic, semantics: Semantics, inputs: &Inputs) -> bool {
        let (rules, features) = (semantics.rules, semantics.features);
        let bounds =
            features.range.then(|| [inputs.t_min, inputs.extent].map(|bound| arithmetic.mul(bound, self.t_denom)));
        let faces: &[Face] = match features.culling {
            _ if arithmetic.makes(Mistake::CullingIgnored) => &[Face::Front, Face::Back],
            Culling::Back => &[Face::Front],
            Culling::Front => &[Face::Back],
            Culling::None => &[Face::Front, Face::Back],
        };
        faces.iter().any(|&face| {
            self.hits(arithmetic, rules, features.edges, face)
                && bounds.is_none_or(|bounds| self.is_within(arithmetic, rules, bounds, face))
        })
    }

    fn hits(&self, arithmetic: &Arithmetic, rules: Rules, rule: EdgeRule, face: Face) -> bool {
        let (edges, t_num) = (self.edges.map(|edge| face.seen(edge)).into_iter(), face.seen(self.t_num));
        match rules {
            Rules::Paper | Rules::Bounds(_) => {
                let is_open = arithmetic.makes(Mistake::OpenEdges);
                let is_once = rule == EdgeRule::Once;
                let has = |(place, edge): (usize, Number)| match edge.is_zero() {
                    true if is_once && !is_open => self.ties[place].is_none_or(|order| order == face.above()),
                    true => !is_open,
                    false => edge.is_above_zero(),
                };
                edges.enumerate().all(has) && !self.t_denom.is_zero() && !self.t_denom.is_nan() && t_num.is_above_zero()
            }
            Rules::Chisel => {
                !edges.into_iter().any(Number::is_below_zero) && !t_num.is_below_zero() && !self.t_denom.is_zero()
            }
        }
    }

    /// Whether the distance is in the range: t_min · t_denom ≤ t_num ≤ extent · t_denom, reversed for a back face. With
    /// `chisel`, whether no comparison shows that it is not.
    fn is_within(&self, arithmetic: &Arithmetic, rules: Rules, bounds: [Number; 2], face: Face) -> bool {
        let ([near, far], t_num) = (bounds.map(|bound| face.seen(bound)), face.seen(self.t_num));
        let is_open = arithmetic.makes(Mistake::OpenRange);
        [near.order(t_num), t_num.order(far)].into_iter().all(|order| match order {
            None => rules == Rules::Chisel,
            Some(Ordering::Equal) => !is_open,
            Some(order) => order.is_lt(),
        })
    }
}
