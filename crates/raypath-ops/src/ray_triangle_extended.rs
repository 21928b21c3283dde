//! The ray-triangle test with optional culling, range and outputs.

use crate::edge_rule::ties;
use crate::operation::run_portable;
use crate::ray_triangle::{Distance, HIT_TEST, Sums, distance};
use crate::{
    Bit, Circuit, EdgeRule, Edges, Kernels, Num, Operation, Order, Ray, RayTriangle, Rounding, Rules, Tie, Triangle,
    bundle,
};

/// [`RayTriangle`] with options. With all of them off, its results are those of [`RayTriangle`]. It has the same name,
/// so a datapath has one or the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RayTriangleExtended {
    /// The rules for special cases.
    pub rules: Rules,
    /// How t_num and t_denom are rounded.
    pub rounding: Rounding,
    /// To which triangles the points of an edge belong.
    pub edges: EdgeRule,
    /// The faces that are not hit.
    pub culling: Culling,
    /// Adds the output `facing`: which face the ray meets.
    pub facing: bool,
    /// Adds the outputs `barycentric_u`, `barycentric_v` and `barycentric_w`: U, V and W.
    pub barycentrics: bool,
    /// Limits hits to distances between the input `t_min` and the ray's extent.
    pub range: bool,
}

impl RayTriangleExtended {
    /// No options, under the rules `paper`.
    pub const PLAIN: Self = Self {
        rules: Rules::Paper,
        rounding: Rounding::Unit,
        edges: EdgeRule::Shared,
        culling: Culling::Back,
        facing: false,
        barycentrics: false,
        range: false,
    };
}

/// The faces of a triangle that a ray passes through.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Culling {
    /// Back faces, whose vertices appear clockwise to the ray. This is the paper's behaviour.
    #[default]
    Back,
    /// Front faces.
    Front,
    /// None: both faces are hit.
    None,
}

bundle! {
    /// A ray, a triangle, and the least distance of a hit.
    pub struct RayTriangleExtendedInput<C> {
        /// The ray. Its extent is read only if the range is tested.
        pub ray: Ray<C>,
        /// The triangle.
        pub triangle: Triangle<C>,
        /// The least distance of a hit, in units of the direction's length. Read only if the range is tested.
        pub t_min: Num<C>,
    }

    /// The outputs of [`RayTriangleOutput`](crate::RayTriangleOutput) and the optional ones, for hits and misses.
    pub struct RayTriangleExtendedOutput<C> {
        /// Numerator of the distance, in units of the direction's length times `t_denom`.
        pub t_num: Num<C>,
        /// Denominator of the distance: U + V + W. It is negative for a back face.
        pub t_denom: Num<C>,
        /// Whether the ray hits the triangle.
        pub triangle_hit: Bit<C>,
        /// U, V and W. Divided by `t_denom` they are the barycentric coordinates.
        pub barycentric: Edges<C>,
        /// The ray meets the front face: `t_denom` is above zero.
        pub facing: Bit<C>,
    }
}

/// The denominator one stage earlier than in [`Sums::of`], so that there is time for products with it.
const fn early(rounding: Rounding) -> Sums {
    match rounding {
        Rounding::Unit => Sums::Unit {
            uv: (7, "U + V"),
            uv_depth: (8, "U Az + V Bz"),
            t_denom: (8, "+ W = t_denom"),
            t_num: (9, "+ W Cz = t_num"),
        },
        Rounding::Sum => Sums::Once { t_denom: 8, t_num: 9 },
    }
}

impl Operation for RayTriangleExtended {
    const NAME: &'static str = RayTriangle::NAME;
    type Input<C: Circuit> = RayTriangleExtendedInput<C>;
    type Output<C: Circuit> = RayTriangleExtendedOutput<C>;
    type State<C: Circuit> = ();

    fn has_input(&self, port: &str) -> bool {
        self.range || port != "t_min"
    }

    fn has_output(&self, port: &str) -> bool {
        match port {
            "facing" => self.facing,
            _ => self.barycentrics || !port.starts_with("barycentric"),
        }
    }

    run_portable!();

    #[inline(always)]
    fn run_with<C: Circuit, K: Kernels<C>>(
        &self,
        c: C,
        kernels: K,
        input: RayTriangleExtendedInput<C>,
        _state: (),
    ) -> (RayTriangleExtendedOutput<C>, ()) {
        let RayTriangleExtendedInput { ray, triangle, t_min } = input;
        let sums = if self.range { early(self.rounding) } else { Sums::of(self.rounding) };
        let met = distance(c, kernels, &ray, triangle, &sums);
        let Distance { sheared, products, edges, t_num, t_denom } = met;
        let ties = match self.edges {
            EdgeRule::Shared => None,
            EdgeRule::Once => Some(ties(c, kernels, sheared, products, edges)),
        };

        let bounds = self.range.then(|| {
            c.stage(9, "t_min and extent times t_denom");
            let bounds = Bounds { near: t_min * t_denom, far: ray.extent * t_denom };
            c.label(format_args!("bound"), &bounds);
            bounds
        });

        // Comparisons with the products of stage 9 need a stage of their own.
        c.stage_or(10, if self.range { 10 } else { HIT_TEST }, "hit test");
        let mirrored = match self.culling {
            Culling::Back => None,
            Culling::Front | Culling::None => Some(mirrored(c, &met)),
        };
        let orders = bounds.map(|bounds| bounds.orders(t_num));
        let hit = |seen: &Distance<C>, is_front: bool| {
            let edges = seen.edges.to_array();
            let inside = match ties {
                None => self.rules.inside(c, edges),
                Some(ties) => {
                    let has = |edge: Num<C>, tie: Tie<C>| {
                        edge.is_above_zero() | (edge.is_zero() & if is_front { tie.front } else { tie.back })
                    };
                    has(edges[0], ties[0]) & has(edges[1], ties[1]) & has(edges[2], ties[2])
                }
            };
            let hit = self.rules.triangle_hit(c, inside, seen.t_num, seen.t_denom);
            orders.map_or(hit, |orders| hit & self.rules.within(orders, is_front))
        };
        let triangle_hit = match (self.culling, mirrored) {
            (Culling::Front, Some(mirrored)) => hit(&mirrored, false),
            (_, Some(mirrored)) => hit(&met, true) | hit(&mirrored, false),
            (_, None) => hit(&met, true),
        };
        c.label(format_args!("triangle_hit"), &triangle_hit);

        let facing = t_denom.is_above_zero();
        (RayTriangleExtendedOutput { t_num, t_denom, triangle_hit, barycentric: edges, facing }, ())
    }
}

/// The triangle with its vertices in the opposite order. Testing its front tests the back of the original.
#[inline(always)]
fn mirrored<C: Circuit>(c: C, met: &Distance<C>) -> Distance<C> {
    let Edges { u, v, w } = met.edges;
    let edges = Edges { u: -u, v: -v, w: -w };
    c.label(format_args!("mirrored_edge"), &edges);
    let t_num = -met.t_num;
    c.label(format_args!("mirrored_t_num"), &t_num);
    // The hit test checks the denominator only for zero and NaN, whose signs do not matter.
    Distance { edges, t_num, ..*met }
}

bundle! {
    /// The ends of a ray, multiplied by the denominator of a distance on it.
    pub struct Bounds<C> {
        /// The least distance of a hit.
        pub near: Num<C>,
        /// The greatest distance of a hit.
        pub far: Num<C>,
    }
}

impl<C: Circuit> Bounds<C> {
    /// Compares the near end with a numerator, and the numerator with the far end.
    #[inline(always)]
    fn orders(self, t_num: Num<C>) -> [Order<C>; 2] {
        [self.near.compare(t_num), t_num.compare(self.far)]
    }
}

names! {
    Culling { Back = "back", Front = "front", None = "none" },
    /// The error of an unknown name of a culling mode.
    ParseCullingError, "'{0}' is not a valid culling mode, expected back, front or none"
}
