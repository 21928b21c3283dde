//! The operations of a ray-tracing datapath, each written once.
//!
//! An [`Operation`] is a function that is generic over a [`Circuit`], with its pipeline stages marked. Over
//! [`Binary32`] it computes with native numbers and is the functional model. Over the recording circuit of crate
//! `raypath-rtl` the same function becomes hardware.
//!
//! ```
//! use raypath_ops::{Aabb, Binary32, Operation, Ray, RayBox, RayBoxInput, Rules};
//!
//! let ray = Ray::new([0.0, 0.0, -5.0], [0.0, 0.0, 1.0], f32::INFINITY)?;
//! let near = Aabb::new([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]);
//! let far = Aabb::new([-1.0, -1.0, 7.0], [1.0, 1.0, 9.0]);
//! let aside = Aabb::new([4.0, 4.0, 4.0], [5.0, 5.0, 5.0]);
//!
//! let job = RayBoxInput { ray, aabb: [far, aside, near, aside] };
//! let (hits, _) = RayBox { rules: Rules::Paper, is_conservative: false }.run(Binary32, job, ());
//! assert_eq!(hits.is_intersect.to_array(), [true, true, false, false]);
//! assert_eq!(hits.box_index.map(u32::from), [2, 0, 1, 3]);
//! assert_eq!(f32::from(hits.tmin[0]), 4.0);
//! # Ok::<(), raypath_ops::RayError>(())
//! ```

#[macro_use]
mod array;
#[macro_use]
mod names;
mod binary32;
mod bundle;
mod bundle_macro;
mod circuit;
mod distance;
mod distance_many;
mod edge_rule;
mod family;
mod flagged;
mod geometry;
mod handle;
mod job;
mod kernels;
mod known;
mod operation;
pub mod operations;
mod ports;
mod ray;
mod ray_box;
mod ray_box_bounds;
mod ray_triangle;
mod ray_triangle_extended;
mod residue;
mod rules;
mod sort;
mod sum;

#[doc(hidden)]
pub use array::array_from;
pub use binary32::{Binary32, Single};
pub use bundle::{Bundle, Field, Path, Sink, Source};
pub use circuit::{Circuit, Concrete, Direction, Narrowing, Relation, Test};
pub use distance::{
    Angular, AngularOutput, AngularState, Beat, BeatInput, Euclidean, EuclideanOutput, EuclideanState, VectorError,
};
pub use distance_many::{AngularMany, AngularManyState, BeatManyInput, EuclideanMany, EuclideanManyState};
pub use edge_rule::{EdgeRule, ParseEdgeRuleError, Tie};
pub use family::{Family, Gather, Of, Put, Scatter};
pub use flagged::Flagged;
pub use geometry::{Aabb, Slab, Triangle, Vec3};
pub use handle::{Bit, Flags, Num, Order, Select, Word};
pub use job::{Job, JobKind, Outcome, ParseJobKindError};
pub use kernels::{Kernels, LaneMap, Portable};
pub use operation::Operation;
pub use ports::{Port, PortKind, PortValue, from_words, ports_of, to_canonical_words, to_words};
pub use ray::{Ray, RayError};
pub use ray_box::{Entry, MARGIN_ULPS, RayBox, RayBoxInput, RayBoxOutput, Slabs};
pub use ray_triangle::{Edges, RayTriangle, RayTriangleInput, RayTriangleOutput};
pub use ray_triangle_extended::{
    Culling, ParseCullingError, RayTriangleExtended, RayTriangleExtendedInput, RayTriangleExtendedOutput,
};
pub use residue::{RESIDUE_BITS, RESIDUE_TINY};
pub use rules::{BoxBits, ParseBoxBitsError, ParseRulesError, Rules};
pub use sort::SortEntry;
pub use sum::{Layout, ParseRoundingError, Rounding};
