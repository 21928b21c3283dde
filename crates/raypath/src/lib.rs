//! An open hardware ray-tracer datapath, described once in Rust.
//!
//! From one function for each operation come synthesizable SystemVerilog ([`rtl`]), a bit-exact functional model and a
//! cycle-exact one ([`model`]). This crate joins them, and adds what surrounds them: files of transactions
//! ([`transactions`]), traffic with bubbles and stalls ([`traffic`]), and engines that carry jobs through any of the
//! three ([`engine`]), for every configuration ([`models`]). Real work goes through the datapath in [`render`] and
//! [`search`]; [`timing`] measures how long it takes, and [`report`] draws it.
//!
//! ```
//! use raypath::ops::{Aabb, Job, Outcome, Ray, RayBoxInput, Rules};
//!
//! let ray = Ray::new([0.0, 0.0, -5.0], [0.0, 0.0, 1.0], f32::INFINITY)?;
//! let boxes = [Aabb::new([-1.0; 3], [1.0; 3]); 4];
//!
//! let mut datapath = raypath::model::Functional::<16, 8>::new(Rules::Paper);
//! let Outcome::Quadbox(hits) = datapath.run(&Job::Quadbox(RayBoxInput { ray, aabb: boxes })) else { unreachable!() };
//! assert_eq!(hits.is_intersect.to_array(), [true; 4]);
//! # Ok::<(), raypath::ops::RayError>(())
//! ```

pub use raypath_float as float;
pub use raypath_float::format;
pub use raypath_hdl as hdl;
pub use raypath_model as model;
pub use raypath_ops as ops;
pub use raypath_oracle as oracle;
pub use raypath_render as render;
pub use raypath_rtl as rtl;
pub use raypath_rtl::report::{picture, tables};
pub use raypath_search as search;
pub use raypath_sim as sim;
pub use raypath_sim::{configuration, engine, jobs, lockstep, models, traffic, transactions};
pub use raypath_timing as timing;
pub use raypath_timing::report;
