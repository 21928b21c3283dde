//! The workbench for operations of one's own.
//!
//! An operation is one function over [`Circuit`](ops::Circuit), with its pipeline stages marked (or left to
//! [`auto`](ops::Circuit::auto)). From it follow its ports, opcode, units, registers and SystemVerilog, a functional and a
//! cycle-exact model, checks and a price. This is all of one, and what can be done with it:
//!
//! ```
//! use raypath_cli::prelude::*;
//! use raypath_cli::Cost;
//! use raypath_cli::oracle::{AnyOperationSpec, Checks};
//!
//! bundle! {
//!     /// A point and a plane: those p with normal · p = offset.
//!     pub struct Side<C> {
//!         /// The point.
//!         pub point: Vec3<C>,
//!         /// The plane's normal, of any length.
//!         pub normal: Vec3<C>,
//!         /// Where the plane is along it.
//!         pub offset: Num<C>,
//!     }
//! }
//!
//! bundle! {
//!     /// On which side the point is.
//!     pub struct Above<C> {
//!         /// normal · p - offset; divided by the normal's length it is the distance.
//!         pub height: Num<C>,
//!         /// It is above 0.
//!         pub is_above: Bit<C>,
//!     }
//! }
//!
//! /// On which side of a plane a point is.
//! struct PointPlane;
//!
//! impl Operation for PointPlane {
//!     const NAME: &'static str = "point_plane";
//!     type Input<C: Circuit> = Side<C>;
//!     type Output<C: Circuit> = Above<C>;
//!     type State<C: Circuit> = ();
//!
//!     fn run<C: Circuit>(&self, c: C, Side { point, normal, offset }: Side<C>, _: ()) -> (Above<C>, ()) {
//!         c.stage(3, "products");
//!         let (x, y, z) = (point.x * normal.x, point.y * normal.y, point.z * normal.z);
//!         c.stage(4, "x + y, z - offset");
//!         let (xy, z) = (x + y, z - offset);
//!         c.stage(6, "their sum");
//!         let height = xy + z;
//!         (Above { height, is_above: height.is_above_zero() }, ())
//!     }
//! }
//!
//! // Beside the paper's four operations it needs no unit of its own.
//! let datapath = Datapath::paper(Default::default()).with(PointPlane);
//! let netlist = datapath.elaborate()?;
//! assert_eq!(netlist.latency(), 12);
//! assert_eq!(Cost::of(&datapath, "point_plane")?.added_units(), Default::default());
//!
//! // One job, by the functional model: 2 above the plane z = 1.
//! let side = Side { point: [5.0, 5.0, 3.0].into(), normal: [0.0, 0.0, 1.0].into(), offset: 1.0.into() };
//! let (above, ()) = PointPlane.run(Binary32, side, ());
//! assert_eq!((f32::from(above.height), bool::from(above.is_above)), (2.0, true));
//!
//! // The same job, cycle by cycle, among the jobs of the others.
//! let mut cycles = datapath.cycle_model()?;
//! let job = datapath.model().job_of::<PointPlane>(&side).expect("one of its operations");
//! assert!(cycles.cycle(Some(&job), true).accepted);
//! assert_eq!(1 + cycles.idle(100), 12);
//! let outcome = cycles.output().expect("an answer");
//! assert_eq!(datapath.model().output_of::<PointPlane>(outcome).map(|above| f32::from(above.height)), Some(2.0));
//!
//! // Random jobs before an oracle, and the netlist beside both models in every cycle.
//! let spec = OperationSpec::of(PointPlane).oracle("the sign alone", |_, answer| {
//!     let height = f32::from(answer.height);
//!     if bool::from(answer.is_above) == (height > 0.0) { Ok(()) } else { Err(format!("at {height}")) }
//! });
//! let specs = [AnyOperationSpec::from(spec)];
//! let checks = Checks { datapath: &datapath, netlist: &netlist, specs: &specs, seed: 1, jobs: 200 };
//! assert_eq!(checks.against_the_oracles()[0].wrong, 0);
//! assert_eq!(checks.against_the_models(|_| true)?.different, 0);
//! # Ok::<(), raypath_cli::CliError>(())
//! ```
//!
//! [`main`](main()) does all of this and more for a crate of one's own, from one command: `examples/within_radius` is such
//! a crate, and the book's chapter for the one who extends builds it step by step.

pub mod accuracy;
mod command;
mod cost;
pub mod emit;
mod error;
mod measure;
mod oracles;
pub mod prelude;
pub mod progress;

pub use raypath_ops as ops;
pub use raypath_oracle as oracle;
pub use raypath_rtl as rtl;
pub use raypath_sim as sim;

pub use command::{Arguments, main, run};
pub use cost::{Cost, Figures};
pub use error::CliError;
pub use measure::measure;
pub use oracles::ask_oracles;
