//! A ray against a sphere, for particles, the ends of curves, and bounding spheres (Haines, Günther, Akenine-Möller,
//! "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems, chapter 7).
//!
//! A datapath with the paper's operations needs no additional units. The operation uses 3 adders in stage 2, 16
//! multipliers in stage 3, 6 adders in stage 4, 3 multipliers in stage 5, 4 adders in stage 6, a multiplier in stage 7,
//! 2 adders in stage 8 and one in stage 9.

use crate::{Bit, Circuit, Num, Operation, Ray, Vec3, bundle};

/// Tests a ray against a sphere and computes the coefficients of the distances. The division and the square root are
/// left to the external circuit.
///
/// Let f be the vector from the origin of the ray to the centre, d the direction, of any length, and r the radius. The
/// ray meets the sphere at the solutions of `a t² - 2 b t + c = 0` with `a = d·d`, `b = f·d` and `c = f·f - r²`. With
/// `q = b ± sqrt(discriminant)`, where the sign is that of b, the solutions are `q / a` and `c / q`.
///
/// The discriminant, `b² - a c`, is computed as `r² a - |f × d|²`, which has the same value but does not lose the
/// radius of a small distant sphere. If the ray starts near the sphere, the difference in c cancels: the error of c is
/// at most 7 u f·f + 3 u r², u = 2⁻²⁴.
///
/// The result is a hit if `discriminant ≥ 0`, `a > 0`, and `b ≥ 0` or `c ≤ 0`: the ray starts inside the sphere or
/// meets it in front of its origin. The extent of the ray is not tested. A NaN in any of the four numbers, or a
/// direction whose square underflows to zero, is a miss. The sign of the radius has no effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sphere;

bundle! {
    /// A centre and a radius.
    pub struct Ball<C> {
        /// The centre.
        pub centre: Vec3<C>,
        /// The radius.
        pub radius: Num<C>,
    }

    /// A ray and a sphere. The operation reads the ray's origin and direction.
    pub struct SphereInput<C> {
        /// The ray.
        pub ray: Ray<C>,
        /// The sphere.
        pub sphere: Ball<C>,
    }

    /// A quadratic equation.
    pub struct Quadratic<C> {
        /// The square of the direction, `d·d`.
        pub a: Num<C>,
        /// Half the linear coefficient, negated: `f·d`. It is positive if the ray runs towards the centre.
        pub b: Num<C>,
        /// `f·f - r²`. It is negative if the ray starts inside the sphere.
        pub c: Num<C>,
        /// A quarter of the discriminant, `r² a - |f × d|²`. It is negative if the line of the ray misses the sphere.
        pub discriminant: Num<C>,
        /// Whether the ray hits the sphere.
        pub hit: Bit<C>,
    }

    /// The coefficients, with the names of the ports.
    pub struct SphereOutput<C> {
        /// The equation.
        pub sphere: Quadratic<C>,
    }
}

impl Operation for Sphere {
    const NAME: &'static str = "sphere";
    type Input<C: Circuit> = SphereInput<C>;
    type Output<C: Circuit> = SphereOutput<C>;
    type State<C: Circuit> = ();

    #[inline(always)]
    fn run<C: Circuit>(&self, circuit: C, input: SphereInput<C>, _state: ()) -> (SphereOutput<C>, ()) {
        let SphereInput { ray: Ray { origin, dir: d, .. }, sphere } = input;

        circuit.stage(2, "f = centre - origin");
        let f = sphere.centre - origin;
        circuit.label(format_args!("to_centre"), &f);

        circuit.stage(3, "products of f × d, f·d, f·f, d·d, r²");
        let across = [[f.y * d.z, f.z * d.y], [f.z * d.x, f.x * d.z], [f.x * d.y, f.y * d.x]];
        let (fd, ff, dd) = (products(f, d), products(f, f), products(d, d));
        let square = sphere.radius * sphere.radius;
        circuit.label(format_args!("across"), &across);
        circuit.label(format_args!("product"), &[fd, ff, dd]);
        circuit.label(format_args!("square"), &square);

        circuit.stage(4, "f × d ; x + y of the dot products");
        let normal: [Num<C>; 3] = array_of!(i => across[i][0] - across[i][1]);
        let [fd_xy, ff_xy, dd_xy] = [fd[0] + fd[1], ff[0] + ff[1], dd[0] + dd[1]];
        circuit.label(format_args!("normal"), &normal);
        circuit.label(format_args!("sum_xy"), &[fd_xy, ff_xy, dd_xy]);

        circuit.stage(5, "squares of f × d");
        let squares: [Num<C>; 3] = array_of!(i => normal[i] * normal[i]);
        circuit.label(format_args!("normal_square"), &squares);

        circuit.stage(6, "a, b, f·f ; x + y of |f × d|²");
        let (b, f_square, a) = (fd_xy + fd[2], ff_xy + ff[2], dd_xy + dd[2]);
        let normal_xy = squares[0] + squares[1];
        circuit.label(format_args!("f_square"), &f_square);
        circuit.label(format_args!("normal_xy"), &normal_xy);

        circuit.stage(7, "r² a");
        let reach = square * a;
        circuit.label(format_args!("reach"), &reach);

        circuit.stage(8, "c ; |f × d|²");
        let (c, apart) = (f_square - square, normal_xy + squares[2]);
        circuit.label(format_args!("apart"), &apart);

        circuit.stage(9, "discriminant = r² a - |f × d|²");
        let discriminant = reach - apart;

        circuit.stage(10, "hit test");
        let before = b.is_at_least_zero() & !c.is_nan();
        let inside = !c.is_above_zero() & !c.is_nan() & !b.is_nan();
        let hit = discriminant.is_at_least_zero() & a.is_above_zero() & (before | inside);

        let sphere = Quadratic { a, b, c, discriminant, hit };
        circuit.label(format_args!("sphere"), &sphere);
        (SphereOutput { sphere }, ())
    }
}

#[inline(always)]
fn products<C: Circuit>(u: Vec3<C>, v: Vec3<C>) -> [Num<C>; 3] {
    [u.x * v.x, u.y * v.y, u.z * v.z]
}
