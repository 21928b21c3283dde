//! Models of the datapath. The functional models compute the outcomes of jobs: [`WordModel`] for any operations, as
//! words at their ports, and [`Functional`] and [`Batch`] for the paper's operations in their own types, which are
//! faster. [`CycleModel`] adds the timing. [`Soft`] and [`Binary64`] are circuits for other formats than binary32.
//!
//! Outcomes depend only on the jobs and their order, timing only on handshakes and the jobs' operations. The
//! cycle-exact model therefore computes an outcome when its job enters, and moves it through a pipeline of the
//! datapath's [`Shape`].
//!
//! ```
//! use raypath_model::{CycleModel, Functional, LATENCY, Shape};
//! use raypath_ops::{Aabb, Binary32, Job, Ray, RayBoxInput, Rules};
//!
//! let ray = Ray::new([0.0, 0.0, -5.0], [0.0, 0.0, 1.0], f32::INFINITY)?;
//! let job: Job = Job::Quadbox(RayBoxInput { ray, aabb: [Aabb::new([-1.0; 3], [1.0; 3]); 4] });
//!
//! let mut datapath = CycleModel::new(Functional::new(Rules::Paper), &Shape::default());
//! assert!(datapath.cycle(Some(&job), true).accepted);
//! let mut cycles = 1;
//! while datapath.output().is_none() {
//!     datapath.cycle(None, true);
//!     cycles += 1;
//! }
//! assert_eq!(cycles, LATENCY);
//! # Ok::<(), raypath_ops::RayError>(())
//! ```

mod batch;
mod binary64;
mod credit;
mod cycle;
mod dynamic;
mod elastic;
mod flow;
mod folded;
mod functional;
mod kernels;
mod lanes;
mod model;
mod one_ray;
mod packed;
mod rounding;
mod shape;
mod skid;
mod soft;
mod state;
mod transpose;
mod word_model;
mod words;

pub use batch::{Batch, blank, levels, pack, run_blocks, run_blocks_in, unpack};
pub use binary64::{Binary64, Double};
pub use cycle::CycleModel;
pub use dynamic::Dynamic;
pub use elastic::{Elastic, Transfer};
#[cfg(not(target_arch = "x86_64"))]
pub use fearless_simd::dispatch;
pub use fearless_simd::{Level, Simd};
pub use flow::Flow;
pub use functional::Functional;
pub use kernels::{Baseline, ModelCircuit, SimdKernels, baseline};
pub use lanes::{Four, Lanes, Native, Register, Width};
pub use model::{Kind, Model};
pub use one_ray::{FourBoxes, FourTriangles, NearestFirst, OneRay};
pub use packed::{BLOCK, BlockSlice, BlockValue, Packed};
pub use rounding::{Exact, LaneRounding, ShortFormat, ShortLanes};
pub use shape::{Control, Loop, PipelinePosition, Shape};
pub use soft::{Soft, SoftNumber};
pub use state::{State, StateWords, restore_state, saved_state};
pub use transpose::transposed;
pub use word_model::{ModelOptions, WordModel, WordOperation};
pub use words::{OperationId, Words};

/// Cycles from the one in which a job is accepted to the one that shows its outcome, in an empty pipeline whose units
/// take one stage.
pub const LATENCY: usize = 12;
