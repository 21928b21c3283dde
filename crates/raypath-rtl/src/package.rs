//! Files for integration: a wrapper with structures as ports, its package, a list of files, manifests for FuseSoC and
//! Bender, constraints and a component of IP-XACT.
//!
//! They are derived from the ports of the top module, so they exist for every set of operations.
//!
//! ```
//! use raypath_rtl::{Config, DatapathNetlist, Lanes, package};
//!
//! let datapath = DatapathNetlist::new(Config::DEFAULT.lanes(Lanes::None))?;
//! let files = package::files(&datapath, &[])?;
//! let (path, text) = &files[0];
//! assert_eq!(path.to_str(), Some("rtl/raypath_wrapper_pkg.sv"));
//! assert!(text.contains("    logic [31:0] extent;\n"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod design;
mod fields;
mod manifest;
mod prefix;
mod soc;
mod structures;
mod text;
mod wrapper;

use crate::DatapathNetlist;
pub use design::{Wrapped, design, wrapped};
use manifest::Sources;
pub use prefix::{Prefix, PrefixError};
use raypath_hdl::{Error, verilog};
pub use soc::{PERIOD_NS, all_ports};
use std::path::PathBuf;
use wrapper::Wrapper;

/// What a datapath is, for manifests.
const PURPOSE: &str = "A ray-tracer datapath";

/// Files with their paths in the output folder.
pub type Files = Vec<(PathBuf, String)>;

/// The files, each with its path in the output folder: `rtl/raypath_wrapper_pkg.sv`, `rtl/raypath_wrapper.sv`,
/// `raypath_wrapper.f`, `raypath.core` and `Bender.yml`. They refer to the files of the package and the modules in
/// `rtl` and to `raypath_properties.sv`, which are not among them. The lines of `banner` begin each file as a comment.
///
/// # Errors
/// A datapath that cannot be printed: different modules of one name.
pub fn files(datapath: &DatapathNetlist, banner: &[String]) -> Result<Files, Error> {
    let top = datapath.top();
    let name = top.name();
    let wrapper_name = format!("{name}_wrapper");
    let mut files = Wrapper::of_datapath(datapath).files(banner);
    let modules = verilog::sources(top, &[])?.iter().map(|source| format!("rtl/{}.sv", source.name)).collect();
    let sources = Sources {
        name,
        description: PURPOSE,
        modules,
        wrapper_name: &wrapper_name,
        wrapper: paths(&files),
        properties: &format!("{name}_properties.sv"),
    };
    let lists = [
        (format!("{wrapper_name}.f").into(), sources.list()),
        (format!("{name}.core").into(), sources.fusesoc(banner)),
        ("Bender.yml".into(), sources.bender(banner)),
    ];
    files.extend(lists);
    Ok(files)
}

/// The paths of files.
fn paths(files: &Files) -> Vec<String> {
    files.iter().map(|(path, _)| path.display().to_string()).collect()
}
