//! The files of a datapath: SystemVerilog, checkers, a picture, and files for integration.

use raypath_hdl::verilog;
use raypath_rtl::report::picture;
use raypath_rtl::{Config, Datapath, Error};
use std::path::{Path, PathBuf};

/// The head comment of the file of assertions.
const PROPERTIES: &str = "Assertions about the control of the pipeline. Compile this file after raypath.sv, with \
    assertions on (verilator --assert). Its last lines bind the checkers to the modules. `raypath verify control` \
    proves them.";

/// The files by path: each module in `rtl/`, listed in `raypath.f`, and all of them in `raypath.sv`;
/// `raypath_properties.sv`; `pipeline.svg`; a wrapper with its package, and manifests
/// ([`raypath_rtl::package::files`]). `banner` is the comment at the head of each file.
///
/// # Errors
/// Names that cannot be printed.
pub fn files(
    datapath: &Datapath,
    config: Config,
    banner: &[String],
    folder: &Path,
) -> Result<Vec<(PathBuf, String)>, Error> {
    let mut files = Vec::new();
    let mut list = String::new();
    let license = format!("// {}\n//\n", verilog::LICENSE);
    let mut all = verilog::head(banner, datapath.top().doc());
    for (source, alone) in
        verilog::sources(datapath.top(), banner)?.into_iter().zip(verilog::sources(datapath.top(), &[])?)
    {
        let name = format!("rtl/{}.sv", source.name);
        list += &format!("{name}\n");
        all += &format!("{}\n", alone.text.trim_start_matches(&license));
        files.push((folder.join(name), source.text));
    }
    files.push((folder.join("raypath.f"), list));
    files.push((folder.join("raypath.sv"), all));
    files.push((
        folder.join("raypath_properties.sv"),
        verilog::head(banner, &[PROPERTIES.to_string()]) + datapath.properties().to_string().trim_start(),
    ));
    files.push((folder.join("pipeline.svg"), picture::pipeline(datapath, config)));
    let package = raypath_rtl::package::files(datapath, banner)?.into_iter();
    files.extend(package.map(|(path, text)| (folder.join(path), text)));
    Ok(files)
}
