//! Fixed-radius neighbour search in a ray-tracing unit: which of four points lie within a radius of a query point.

pub mod first_cut;
pub mod nearest;

// ANCHOR: operation
use raypath::prelude::*;

// ANCHOR: structures
bundle! {
    /// A query point with a radius, and four candidate points.
    pub struct Points<C> {
        /// The query point.
        pub query: Vec3<C>,
        /// The radius.
        pub radius: Num<C>,
        /// The candidate points.
        pub point: [Vec3<C>; 4],
    }
}

bundle! {
    /// The results for the four points.
    pub struct Near<C> {
        /// Whether each point lies within the radius.
        pub is_near: Flags<C, 4>,
        /// The square of the distance of each point.
        pub squared_distance: [Num<C>; 4],
    }
}
// ANCHOR_END: structures

/// Tests which of four points lie within a radius of a query point.
pub struct WithinRadius;

impl Operation for WithinRadius {
    const NAME: &'static str = "within_radius";
    type Input<C: Circuit> = Points<C>;
    type Output<C: Circuit> = Near<C>;
    type State<C: Circuit> = ();

    // ANCHOR: function
    fn run<C: Circuit>(&self, c: C, Points { query, radius, point }: Points<C>, _: ()) -> (Near<C>, ()) {
        c.stage(2, "point - query");
        let away = point.map(|point| point - query);
        c.stage(3, "squares");
        let squares = away.map(|Vec3 { x, y, z }| [x * x, y * y, z * z]);
        let limit = radius * radius;
        c.stage(4, "x² + y²");
        let in_plane = squares.map(|[x, y, _]| x + y);
        c.stage(6, "+ z²");
        let squared_distance: [Num<C>; 4] = std::array::from_fn(|i| in_plane[i] + squares[i][2]);
        c.stage(10, "against the square of the radius");
        let is_near = Flags(squared_distance.map(|square| square.compare(limit).less_or_equal()));
        (Near { is_near, squared_distance }, ())
    }
    // ANCHOR_END: function
}
// ANCHOR_END: operation

// ANCHOR: spec
/// The operation with random jobs and an independent oracle.
pub fn spec() -> OperationSpec<WithinRadius> {
    OperationSpec::of(WithinRadius)
        .purpose("which of four points are near another")
        .stimulus(stimulus)
        .oracle("f64", check)
}

/// Random points at scales from 2^-20 to 2^20. Some coordinates are equal, which gives distances equal to the radius.
pub fn stimulus(rng: &mut ChaCha8Rng) -> Points<Binary32> {
    let size = 2.0_f32.powi(rng.random_range(-20..20));
    let mut number = || size * if rng.random_bool(0.2) { 0.5 } else { rng.random_range(-1.0..1.0) };
    let mut vector = || [number(), number(), number()].into();
    Points { query: vector(), point: [vector(), vector(), vector(), vector()], radius: number().abs().into() }
}

/// Compares a result with distances in binary64, within the rounding errors of binary32.
pub fn check(job: &Points<Binary32>, answer: &Near<Binary32>) -> Result<(), String> {
    const ROUNDINGS: f64 = 6.0 / (1 << 24) as f64;
    let limit = f64::from(f32::from(job.radius)).powi(2);
    let query: [f32; 3] = job.query.into();
    for (i, point) in job.point.into_iter().enumerate() {
        let point: [f32; 3] = point.into();
        let exact: f64 = (0..3).map(|k| (f64::from(point[k]) - f64::from(query[k])).powi(2)).sum();
        let found = f64::from(f32::from(answer.squared_distance[i]));
        if found.is_nan() || (found - exact).abs() > ROUNDINGS * exact {
            return Err(format!("point {i}: squared distance {found}, expected {exact}"));
        }
        let is_near = bool::from(answer.is_near.0[i]);
        if is_near != (exact <= limit) && (exact - limit).abs() > ROUNDINGS * (exact + limit) {
            return Err(format!("point {i}: near is {is_near}, at {exact} of {limit}"));
        }
    }
    Ok(())
}
// ANCHOR_END: spec
