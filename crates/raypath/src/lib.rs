//! An open hardware ray-tracer datapath, described once in Rust.
//!
//! From one function for each operation ([`ops`]) come synthesizable SystemVerilog ([`rtl`]), a bit-exact functional
//! model and a cycle-exact model ([`model`]). [`sim`] joins them: a datapath of any operations, engines that carry jobs
//! through netlist and models, traffic with bubbles and stalls, and transaction files. [`oracle`] has what the test of
//! an operation needs.
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
//!
//! | feature | adds |
//! | --- | --- |
//! | `cli` (default) | the program `raypath` with the commands `generate`, `configs`, `operations`, `new-operation`, `ray` |
//! | `workbench` | modules `workbench` and `prelude`: the command line for a crate with an operation of its own |
//! | `full` | all commands, and the modules `render`, `search` and `timing` |

#[cfg(feature = "workbench")]
pub use raypath_cli::{prelude, workbench};
pub use raypath_float as float;
pub use raypath_hdl as hdl;
pub use raypath_model as model;
pub use raypath_ops as ops;
pub use raypath_oracle as oracle;
#[cfg(feature = "full")]
pub use raypath_render as render;
pub use raypath_rtl as rtl;
#[cfg(feature = "full")]
pub use raypath_search as search;
pub use raypath_sim as sim;
#[cfg(feature = "full")]
pub use raypath_timing as timing;
