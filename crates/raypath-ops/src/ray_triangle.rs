//! The watertight test of a ray against a triangle (Woop, Benthin and Wald; Table VII, column Triangle).

use crate::operation::run_portable;
use crate::{Binary32, Bit, Circuit, Kernels, LaneMap, Num, Operation, Ray, Rounding, Rules, Triangle, Vec3, bundle};

/// Tests a ray against the front of a triangle and computes the distance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RayTriangle {
    /// The rules for special cases.
    pub rules: Rules,
    /// How t_num and t_denom, sums of three terms each, are rounded.
    pub rounding: Rounding,
}

bundle! {
    /// A ray and a triangle. The operation reads the ray's origin, shear and axes.
    pub struct RayTriangleInput<C> {
        /// The ray.
        pub ray: Ray<C>,
        /// The triangle.
        pub triangle: Triangle<C>,
    }

    /// The distance as a fraction; the datapath does not divide. Both parts are computed for hits and misses.
    pub struct RayTriangleOutput<C> {
        /// Numerator of the distance, in units of the direction's length times `t_denom`.
        pub t_num: Num<C>,
        /// Denominator of the distance: U + V + W.
        pub t_denom: Num<C>,
        /// Whether the ray hits the triangle.
        pub triangle_hit: Bit<C>,
    }

    /// The scaled barycentric coordinates U, V, W. Their signs give the side of each edge on which the ray passes.
    pub struct Edges<C> {
        /// U: the side of edge BC.
        pub u: Num<C>,
        /// V: the side of edge CA.
        pub v: Num<C>,
        /// W: the side of edge AB.
        pub w: Num<C>,
    }
}

impl<C: Circuit> Edges<C> {
    /// U, V and W.
    #[inline(always)]
    pub(crate) fn to_array(self) -> [Num<C>; 3] {
        [self.u, self.v, self.w]
    }
}

impl Operation for RayTriangle {
    const NAME: &'static str = "triangle";
    type Input<C: Circuit> = RayTriangleInput<C>;
    type Output<C: Circuit> = RayTriangleOutput<C>;
    type State<C: Circuit> = ();

    run_portable!();

    #[inline(always)]
    fn run_with<C: Circuit, K: Kernels<C>>(
        &self,
        circuit: C,
        kernels: K,
        input: RayTriangleInput<C>,
        _state: (),
    ) -> (RayTriangleOutput<C>, ()) {
        let RayTriangleInput { ray, triangle } = input;
        let Distance { edges, t_num, t_denom, .. } =
            distance(circuit, kernels, &ray, triangle, &Sums::of(self.rounding));

        circuit.stage_or(10, HIT_TEST, "hit test");
        let inside = self.rules.inside(circuit, edges.to_array());
        let triangle_hit = self.rules.triangle_hit(circuit, inside, t_num, t_denom);
        circuit.label(format_args!("triangle_hit"), &triangle_hit);

        (RayTriangleOutput { t_num, t_denom, triangle_hit }, ())
    }
}

/// Where a ray meets a triangle's plane, and on which sides of its edges.
#[derive(Clone, Copy)]
pub(crate) struct Distance<C: Circuit> {
    /// The sheared vertices a, b, c.
    pub sheared: [Vec3<C>; 3],
    /// The products of which U, V and W are the differences.
    pub products: [(Num<C>, Num<C>); 3],
    pub edges: Edges<C>,
    pub t_num: Num<C>,
    pub t_denom: Num<C>,
}

/// The stages of the sums over U, V and W, with their titles in the schedule.
#[derive(Clone, Copy)]
pub(crate) enum Sums {
    /// Every addition rounds.
    Unit {
        /// U + V
        uv: (u32, &'static str),
        /// U Az + V Bz
        uv_depth: (u32, &'static str),
        /// + W
        t_denom: (u32, &'static str),
        /// + W Cz
        t_num: (u32, &'static str),
    },
    /// Both sums of three terms round once. These are the stages in which they are available.
    Once {
        /// U + V + W
        t_denom: u32,
        /// U Az + V Bz + W Cz
        t_num: u32,
    },
}

/// The stage of the hit test if sums round once.
pub(crate) const HIT_TEST: u32 = 9;

impl Sums {
    /// The stages of Table VII, or those of sums that round once.
    pub(crate) const fn of(rounding: Rounding) -> Self {
        match rounding {
            Rounding::Unit => Self::Unit {
                uv: (8, "U + V ; U Az + V Bz"),
                uv_depth: (8, "U + V ; U Az + V Bz"),
                t_denom: (9, "+ W = t_denom ; + W Cz = t_num"),
                t_num: (9, "+ W = t_denom ; + W Cz = t_num"),
            },
            Rounding::Sum => Self::Once { t_denom: HIT_TEST, t_num: HIT_TEST },
        }
    }
}

/// The arithmetic of a triangle test up to the hit test.
#[inline(always)]
pub(crate) fn distance<C: Circuit>(
    circuit: C,
    kernels: impl Kernels<C>,
    ray: &Ray<C>,
    triangle: Triangle<C>,
    sums: &Sums,
) -> Distance<C> {
    let [a, b, c] = kernels.map(circuit, &Shear, ray, &[triangle.a, triangle.b, triangle.c]);
    circuit.label(format_args!("sheared"), &[a, b, c]);

    circuit.stage(5, "products of U, V, W");
    let products = [(c.x * b.y, c.y * b.x), (a.x * c.y, a.y * c.x), (b.x * a.y, b.y * a.x)];
    for ((plus, minus), edge) in products.iter().zip(["u", "v", "w"]) {
        circuit.label(format_args!("{edge}_plus"), plus);
        circuit.label(format_args!("{edge}_minus"), minus);
    }

    circuit.stage(6, "U, V, W");
    let [u, v, w]: [Num<C>; 3] = array_of!(i => products[i].0 - products[i].1);
    let edges = Edges { u, v, w };
    circuit.label(format_args!("edge"), &edges);

    circuit.stage(7, "U Az, V Bz, W Cz");
    let (uaz, vbz, wcz) = (u * a.z, v * b.z, w * c.z);
    circuit.label(format_args!("edge_depth"), &[uaz, vbz, wcz]);

    let (t_denom, t_num) = match *sums {
        Sums::Unit { uv: at_uv, uv_depth: at_uv_depth, t_denom: at_t_denom, t_num: at_t_num } => {
            circuit.stage(at_uv.0, at_uv.1);
            let uv = u + v;
            circuit.stage(at_uv_depth.0, at_uv_depth.1);
            let uv_depth = uaz + vbz;
            circuit.label(format_args!("uv"), &uv);
            circuit.label(format_args!("uv_depth"), &uv_depth);

            circuit.stage(at_t_denom.0, at_t_denom.1);
            let t_denom = uv + w;
            circuit.stage(at_t_num.0, at_t_num.1);
            (t_denom, uv_depth + wcz)
        }
        Sums::Once { t_denom: at_t_denom, t_num: at_t_num } => {
            circuit.stage(at_t_denom - 1, "terms of t_denom aligned and added");
            circuit.stage(at_t_denom, "t_denom = U + V + W, rounded once");
            let t_denom = Num::sum([u, v, w]);
            circuit.stage(at_t_num - 1, "terms of t_num aligned and added");
            circuit.stage(at_t_num, "t_num = U Az + V Bz + W Cz, rounded once");
            (t_denom, Num::sum([uaz, vbz, wcz]))
        }
    };
    circuit.label(format_args!("t_denom"), &t_denom);
    circuit.label(format_args!("t_num"), &t_num);

    Distance { sheared: [a, b, c], products, edges, t_num, t_denom }
}

/// Transforms vertices into the ray's coordinate system, in which the ray runs along z.
struct Shear;

impl LaneMap for Shear {
    type Shared = Ray<Binary32>;
    type Item = Vec3<Binary32>;
    type Output = Vec3<Binary32>;

    #[inline(always)]
    fn run<C: Circuit, K: Kernels<C>, const N: usize>(
        &self,
        circuit: C,
        _kernels: K,
        ray: &Ray<C>,
        vertices: &[Vec3<C>; N],
    ) -> [Vec3<C>; N] {
        // Table VII permutes the differences. Permuting their operands gives the same numbers, in stage 1, which has
        // time for it.
        circuit.stage(1, "axes permuted so that the ray looks along z");
        let origin = ray.turned(ray.origin);
        let vertices: [Vec3<C>; N] = array_of!(i => ray.turned(vertices[i]));
        circuit.label(format_args!("turned_origin"), &origin);
        circuit.label(format_args!("turned"), &vertices);

        circuit.stage(2, "each vertex - origin");
        let relative: [Vec3<C>; N] = array_of!(i => vertices[i] - origin);
        circuit.label(format_args!("relative"), &relative);

        circuit.stage(3, "Sx, Sy, Sz times each vertex's kz coordinate");
        let shift: [Vec3<C>; N] = array_of!(i => ray.shear * relative[i].z);
        circuit.label(format_args!("shift"), &shift);

        circuit.stage(4, "shear: x and y of each vertex");
        array_of!(i => Vec3 { x: relative[i].x - shift[i].x, y: relative[i].y - shift[i].y, z: shift[i].z })
    }
}
