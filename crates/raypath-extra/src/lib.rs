//! Operations that the field asks for beside the paper's, each in its own file, written only against what `raypath-ops`
//! shows. A datapath has those that it is given, and none of these by default.
//!
//! `raypath operations` lists them, with what each adds to a datapath that has the paper's four.
//!
//! Beside its operation each file has what verification needs: `stimulus` draws a random job that matters, and `judge`
//! says what is wrong with an answer, by exact arithmetic or by counting, not by the operation's own equations.
//! A new operation is a new file in `src/operations`, which registers itself; nothing else names it.
//!
//! ```
//! use raypath_extra::point_in_box::{PointInBox, PointInBoxInput};
//! use raypath_ops::{Aabb, Binary32, Operation};
//!
//! let unit = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
//! let job = PointInBoxInput { point: [1.0, 0.5, 0.0].into(), aabb: [0.0, 0.5, 1.0, 1.5].map(unit) };
//! let (answer, ()) = PointInBox.run(Binary32, job, ());
//! assert_eq!(answer.is_inside.to_array(), [true, true, true, false]);
//! ```

mod draw;
mod exact;
mod slabs;

#[cfg(test)]
mod check;

mod operations {
    automod::dir!(pub "src/operations");
}

pub use operations::*;
