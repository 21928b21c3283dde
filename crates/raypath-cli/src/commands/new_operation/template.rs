//! The side of a plane on which a point lies: replace it by an operation of your own.

use raypath::prelude::*;
use std::process::ExitCode;

bundle! {
    /// A point and a plane: those p with normal · p = offset. Each field is an input port.
    pub struct Side<C> {
        /// The point.
        pub point: Vec3<C>,
        /// The plane's normal, of any length.
        pub normal: Vec3<C>,
        /// The plane's position along the normal.
        pub offset: Num<C>,
    }

    /// The side of the point. Each field is an output port.
    pub struct Above<C> {
        /// normal · p - offset; divided by the normal's length it is the distance.
        pub height: Num<C>,
        /// Whether the height is above 0.
        pub is_above: Bit<C>,
    }
}

/// The side of a plane on which a point lies.
pub struct PointPlane;

impl Operation for PointPlane {
    const NAME: &'static str = "point_plane";
    type Input<C: Circuit> = Side<C>;
    type Output<C: Circuit> = Above<C>;
    type State<C: Circuit> = ();

    fn run<C: Circuit>(&self, c: C, Side { point, normal, offset }: Side<C>, _: ()) -> (Above<C>, ()) {
        // The elaborator chooses the stages. `c.stage(3, "products")` and so on chooses them by hand.
        c.auto();
        let height = point.x * normal.x + point.y * normal.y + point.z * normal.z - offset;
        (Above { height, is_above: height.is_above_zero() }, ())
    }
}

/// Compares a result with binary64, within the roundings of binary32.
fn check(job: &Side<Binary32>, answer: &Above<Binary32>) -> Result<(), String> {
    let number = |x: Num<Binary32>| f64::from(f32::from(x));
    let [px, py, pz] = <[f32; 3]>::from(job.point).map(f64::from);
    let [nx, ny, nz] = <[f32; 3]>::from(job.normal).map(f64::from);
    let terms = [px * nx, py * ny, pz * nz, -number(job.offset)];
    let (exact, size) = terms.iter().fold((0.0, 0.0), |(sum, size), term| (sum + term, size + term.abs()));
    let found = number(answer.height);
    // A sum of NaN or infinity, or one that may overflow, is not judged.
    let is_judged = size < f64::from(f32::MAX);
    let is_right = !is_judged || (found - exact).abs() <= 1e-6 * size + 1e-37;
    if is_right && bool::from(answer.is_above) == (found > 0.0) {
        return Ok(());
    }
    Err(format!("height {found}, expected {exact}; above: {}", bool::from(answer.is_above)))
}

/// The operation with an oracle.
pub fn spec() -> OperationSpec<PointPlane> {
    OperationSpec::of(PointPlane).purpose("the side of a plane on which a point lies").oracle("f64", check)
}

/// Generates the hardware, checks it, and reports its cost.
pub fn main() -> ExitCode {
    raypath::workbench::main(spec())
}
