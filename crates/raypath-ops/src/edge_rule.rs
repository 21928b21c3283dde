//! To which triangles the points of an edge belong.

use crate::{Bit, Circuit, Edges, Kernels, Num, RESIDUE_BITS, RESIDUE_TINY, Vec3, Word, bundle};

/// To which of the triangles that share an edge its points belong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum EdgeRule {
    /// To all. This is the paper's behaviour.
    #[default]
    Shared,
    /// To one: a ray hits exactly one triangle of a surface whose triangles face it, also through an edge or a vertex.
    /// `docs/reference/error-bounds.md` has the conditions and the proof.
    Once,
}

names! {
    EdgeRule { Shared = "shared", Once = "once" },
    /// The error of an unknown name of a rule for edges.
    ParseEdgeRuleError, "'{0}' is not a valid rule for edges, expected shared or once"
}

bundle! {
    /// Whether each face has an edge on which the ray passes as computed, so that its edge function is 0.
    pub struct Tie<C> {
        /// The front has it.
        pub front: Bit<C>,
        /// The back has it.
        pub back: Bit<C>,
    }
}

/// The ties of the edges U, V and W of a triangle with these sheared vertices, whose edge functions are differences of
/// these products.
#[inline(always)]
pub(crate) fn ties<C: Circuit>(
    c: C,
    kernels: impl Kernels<C>,
    [va, vb, vc]: [Vec3<C>; 3],
    products: [(Num<C>, Num<C>); 3],
    edges: Edges<C>,
) -> [Tie<C>; 3] {
    let ends = [(vb, vc), (vc, va), (va, vb)];
    let edges = edges.to_array();
    let ties: [Tie<C>; 3] = array_of!(i => kernels.tie(c, ends[i], products[i], edges[i]));
    c.label(format_args!("tie"), &ties);
    ties
}

impl<C: Circuit> Tie<C> {
    /// The tie of an edge between these sheared vertices, whose edge function is the difference of the products
    /// x of the end times y of the start and the reverse. It has a meaning if these are equal after rounding.
    ///
    /// The exact products decide. If they are equal, too, the edge belongs to the face for which it leads from the lower
    /// half-plane to the upper, or from the lower to the origin or from there to the upper. If a product is below the
    /// normal range, nothing is known of its digits, and both faces have the edge.
    #[inline(always)]
    pub(crate) fn between(c: C, (start, end): (Vec3<C>, Vec3<C>), (plus, minus): (Num<C>, Num<C>)) -> Self {
        c.stage(5, "what rounding takes from the products");
        let (of_plus, of_minus) = (plus.residue(end.x, start.y), minus.residue(end.y, start.x));
        c.label(format_args!("residue"), &[of_plus, of_minus]);

        c.stage(6, "ties by residues, or by half-planes");
        let normal = |residue: Word<C, RESIDUE_BITS>| residue.less(c.word(RESIDUE_TINY));
        let is_shared = !(normal(of_plus) & normal(of_minus));
        let (more, less) = (of_minus.less(of_plus), of_plus.less(of_minus));
        let (greater, lesser) = plus.sign_bit().exchange(more, less);
        let [(start_up, start_down), (end_up, end_down)] = [half_planes(start), half_planes(end)];
        let leads_up = (end_up & !start_up) | (start_down & !end_down);
        let leads_down = (end_down & !start_down) | (start_up & !end_up);
        Self { front: is_shared | greater | (!lesser & leads_up), back: is_shared | lesser | (!greater & leads_down) }
    }
}

/// Whether a point is in the upper half-plane, with the positive half of the x axis, and whether in the lower with the
/// negative half. The origin is in neither.
#[inline(always)]
fn half_planes<C: Circuit>(point: Vec3<C>) -> (Bit<C>, Bit<C>) {
    let on_axis = point.y.is_zero();
    let up = point.y.is_above_zero() | (on_axis & point.x.is_above_zero());
    let down = point.y.is_below_zero() | (on_axis & point.x.is_below_zero());
    (up, down)
}
