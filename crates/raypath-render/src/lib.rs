//! Ray tracing and rendering with the operations of the datapath.
//!
//! Each test of a ray against four boxes or a triangle is a job of the datapath: [`RayBox`](raypath_ops::RayBox) or
//! [`RayTriangle`](raypath_ops::RayTriangle). This crate is the external circuit that *A Hardware Ray Tracer Datapath
//! with Generalized Features* leaves outside: the traversal stack, the division t_num / t_denom, and shading.
//! [`Traversal`] is that circuit for one ray. [`trace_closest`], [`trace_any`] and [`render`](render()) execute its
//! jobs directly in software; [`time_rays`] and [`time_picture`] send them through a cycle-exact model of the pipeline
//! and count cycles.

pub mod builtin;
pub mod camera;
pub mod compare;
pub mod instances;
pub mod picture;
pub mod rays;
pub mod read;
pub mod render;
pub mod timing;
pub mod trace;

pub use builtin::builtin;
pub use camera::{Camera, CameraError};
pub use instances::{parse_instances, read_instances};
pub use picture::{Picture, heatmap, to_png};
pub use raypath_scene::{
    Blocks, BlocksError, Bounds, Bvh4, CwbvhError, Mesh, MeshError, Placement, PlacementError, RefitError, Scene,
    SceneError, blocks, bvh, mesh, placement, refit,
};
pub use rays::{parse_hits, parse_rays, read_hits, read_rays, write_hits, write_rays};
pub use read::{Format, ReadError, parse_mesh, read_mesh};
pub use render::{Costs, RenderError, Rendering, Rows, Shading, draw, render, render_rows};
pub use timing::{
    PictureError, PictureSpec, RayBatch, UnitSystem, picture_jobs, sweep_picture, sweep_rays, time_picture,
    time_picture_through_unit, time_rays, time_rays_through_unit,
};
pub use trace::{
    Counts, Goal, Hit, Stopped, TraceError, Tracer, Tracing, Traversal, UnitErrors, trace_any, trace_closest,
};
