//! The slab method in few bits, rounded outwards (rules `bounds`).
//!
//! A distance at which the ray enters a slab matters only if it is above zero, and so does one at which it leaves. So
//! a near distance is a lower bound if every magnitude is rounded toward zero, and a far distance an upper bound if
//! every magnitude is rounded away from zero. `docs/reference/error-bounds.md` has the proof.

use crate::ray_box::SlabEnds;
use crate::{Aabb, Bit, BoxBits, Circuit, Kernels, Narrowing, Num, Ray};

/// Units in the last place by which the inverse of a direction's component is moved before it is rounded.
///
/// A slab distance has three roundings to nearest: of the inverse, of the difference, and of the product, each by a
/// factor of at most 1 + u, where u is half a unit in the last place of 1. Four units change the inverse by a factor
/// of at least 1 + 4u, which exceeds (1 + u)^3.
const INVERSE_MARGIN: u32 = 4;

/// Two bounds, distances or inverses: the one at which the ray enters a slab, and the one at which it leaves.
type Ends<C> = (Num<C>, Num<C>);

/// For each slab of each box, a lower bound of the distance at which the ray enters, and an upper bound of the distance
/// at which it leaves; and the extent, rounded as the latter. In stages 1 to 4.
#[inline(always)]
pub(crate) fn outer_ends<C: Circuit, const N: usize>(
    c: C,
    kernels: impl Kernels<C>,
    BoxBits(bits): BoxBits,
    ray: &Ray<C>,
    aabb: &[Aabb<C>; N],
) -> ([SlabEnds<C>; N], Num<C>) {
    let (toward, away) = (Narrowing::toward_zero(bits), Narrowing::away_from_zero(bits));
    let origin = [ray.origin.x, ray.origin.y, ray.origin.z];
    let inv = [ray.inv.x, ray.inv.y, ray.inv.z];

    c.stage(1, "near and far bounds by the sign of inv");
    let backwards: [Bit<C>; 3] = array_of!(k => inv[k].sign_bit());
    let bounds: [[Ends<C>; 3]; N] = array_of!(i => {
        let slabs = [aabb[i].x, aabb[i].y, aabb[i].z];
        array_of!(k => kernels.exchange(backwards[k], slabs[k].min, slabs[k].max))
    });

    c.stage(2, "bound - origin: near ones rounded toward zero, far ones away from it; inv both ways");
    let relative: [[Ends<C>; 3]; N] = array_of!(i => array_of!(k => {
        let (near, far) = bounds[i][k];
        ((near - origin[k]).narrow(toward), (far - origin[k]).narrow(away))
    }));
    let inverse: [Ends<C>; 3] = array_of!(k =>
        (inv[k].narrow(toward.margin(INVERSE_MARGIN)), inv[k].narrow(away.margin(INVERSE_MARGIN)))
    );
    let extent = ray.extent.narrow(away);
    name(c, "bound", &bounds);
    name(c, "relative", &relative);
    for (k, axis) in AXES.iter().enumerate() {
        c.label(format_args!("inv_{axis}_near"), &inverse[k].0);
        c.label(format_args!("inv_{axis}_far"), &inverse[k].1);
    }
    c.label(format_args!("extent_far"), &extent);

    c.stage(3, "times inv: bounds of the slab distances");
    // The near products first: they are the first to share multipliers, and rounding toward zero takes no time.
    let near: [[Num<C>; 3]; N] = array_of!(i => array_of!(k => (relative[i][k].0 * inverse[k].0).narrow(toward)));
    let far: [[Num<C>; 3]; N] = array_of!(i => array_of!(k => (relative[i][k].1 * inverse[k].1).narrow(away)));
    let distance: [[Ends<C>; 3]; N] = array_of!(i => array_of!(k => (near[i][k], far[i][k])));
    name(c, "distance", &distance);

    c.stage(4, "tmin = max(near, 0), tmax = min(far, extent)");
    (distance, extent)
}

const AXES: [&str; 3] = ["x", "y", "z"];

/// Names the ends of all slabs: `<stem>_<box>_<axis>_near` and `_far`.
#[inline(always)]
fn name<C: Circuit, const N: usize>(c: C, stem: &str, boxes: &[[Ends<C>; 3]; N]) {
    for (i, slabs) in boxes.iter().enumerate() {
        for ((near, far), axis) in slabs.iter().zip(AXES) {
            c.label(format_args!("{stem}_{i}_{axis}_near"), near);
            c.label(format_args!("{stem}_{i}_{axis}_far"), far);
        }
    }
}
