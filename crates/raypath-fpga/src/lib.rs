//! A datapath on an FPGA.
//!
//! [`Shell`] is a module around a datapath with few pins: a stream of bytes or of words of 32 bits in, another one out.
//! [`Host`] is the other side of these streams: it sends jobs and compares the outcomes with the model. [`Flow`] makes
//! a bitstream of a shell with Yosys, nextpnr and ecppack, and a [`Report`] of it. [`reduced`] is a shell that measures
//! the clock of any design. `docs/integration/fpga.md` describes
//! the streams and says what the figures include.
//!
//! ```no_run
//! use raypath_fpga::{Device, Flow, Shell, StreamWidth, Target};
//! use raypath_rtl::{Config, DatapathNetlist, Multiplier};
//! use raypath_tools::Yosys;
//!
//! let config = Config::DEFAULT.multiplier(Multiplier::Inferred);
//! let shell = Shell::new(DatapathNetlist::new(config)?.top(), StreamWidth::Eight)?;
//! let flow = Flow { yosys: Yosys::find(None)?, cache: "build/ppa-cache".into() };
//! let implemented = flow.implement("paper", &shell.top, &[Target::of(Device::Ecp5_85k)], |_| true)?;
//! println!("{:?}", implemented.report.routed);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod device;
mod flow;
mod frame;
mod host;
mod netlist;
mod products;
mod project;
mod report;
mod shell;
pub mod tables;
mod timing;

pub use device::{Device, ParseDeviceError, Target};
pub use flow::{Flow, Implementation};
pub use frame::{Field, Frame, StreamWidth};
pub use host::{Comparison, Host};
pub use project::{ParseProjectError, Project};
pub use raypath_work::pool::Progress;
pub use report::{Cells, Report, Routed, Run, Stage, Step, Use};
pub use shell::{Shell, reduced};
pub use timing::Timing;
