//! Rendering through the datapath's operations.
//!
//! Every test of a ray against boxes or a triangle is a job of the datapath: [`RayBox`](raypath_ops::RayBox) and
//! [`RayTriangle`](raypath_ops::RayTriangle). What stands around them is the external circuit of *A Hardware Ray Tracer
//! Datapath with Generalized Features*: the stack, the division t_num / t_denom, and shading. [`Traversal`] is that
//! circuit for one ray, an agent that says which jobs it needs: [`trace_closest`] and [`trace_any`] answer them at once, and
//! [`time_picture`] and [`time_rays`] by a cycle-exact model of the datapath, to see how long that takes.

pub mod builtin;
pub mod bvh;
pub mod camera;
pub mod compare;
pub mod mesh;
pub mod picture;
mod progress;
pub mod rays;
pub mod read;
pub mod render;
mod scene;
pub mod timing;
pub mod trace;
mod vector;

pub use builtin::builtin;
pub use bvh::Bvh4;
pub use camera::{Camera, CameraError};
pub use mesh::{Bounds, Mesh, MeshError};
pub use picture::{Picture, heatmap};
pub use progress::Stopped;
pub use rays::{RaysError, parse_rays, read_rays, write_hits};
pub use read::{Format, ReadError, parse_mesh, read_mesh};
pub use render::{RenderError, Rendering, Shading, render};
pub use scene::Scene;
pub use timing::{Bundle, PictureError, Still, sweep_picture, sweep_rays, time_picture, time_rays};
pub use trace::{Counts, Goal, Hit, Tracer, Tracing, Traversal, trace_any, trace_closest};
