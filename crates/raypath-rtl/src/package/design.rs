//! All files of a design: SystemVerilog, assertions, a picture, and the files for integration.

use super::manifest::Sources;
use super::wrapper::Wrapper;
use super::{Files, paths, soc};
use crate::report::picture;
use crate::{Config, DatapathNetlist};
use raypath_hdl::{Error, Module, text, verilog};
use std::sync::Arc;

/// All files of a datapath: each module in `rtl/`, listed in `raypath.f`, and all of them in `raypath.sv`; the same
/// without package and structures in `raypath_plain.sv`; `raypath_properties.sv`; `pipeline.svg`; and the files for
/// integration ([`files`](super::files)), with `raypath.sdc`, `raypath.xdc` for a clock of `period_ns`, and
/// `raypath.xml` (IP-XACT). `description` says what the datapath is, in the comment at the head of each file.
///
/// # Errors
/// A datapath that cannot be printed: different modules of one name.
pub fn design(datapath: &DatapathNetlist, config: Config, description: &str, period_ns: f64) -> Result<Files, Error> {
    let banner = &banner(description);
    let Printed { mut files, names, all } = Printed::of(datapath.top(), banner)?;
    files.push(("raypath.f".into(), list(&names)));
    files.push(("raypath.sv".into(), all));
    files.push(("raypath_plain.sv".into(), plain(datapath.top(), banner)?));
    files.push(("raypath_properties.sv".into(), checkers(&datapath.properties().to_string(), "raypath.sv", banner)));
    files.push(("pipeline.svg".into(), picture::pipeline(datapath, config)));
    files.extend(super::files(datapath, banner)?);
    files.extend(soc::files(datapath.top(), &names, super::PURPOSE, banner, period_ns));
    Ok(files)
}

/// A design around a datapath, and a wrapper around it that changes its ports.
#[derive(Debug, Clone, Copy)]
pub struct Wrapped<'a> {
    /// The top module of the design.
    pub top: &'a Arc<Module>,
    /// The wrapper, which instantiates the top module, if there is one besides that with structures.
    pub wrapper: Option<&'a Arc<Module>>,
    /// The name, the comment and the text of modules that instantiate those of the wrapper, the top module last.
    pub beyond: &'a [[String; 3]],
    /// The text of the assertions about its modules.
    pub properties: &'a str,
    /// The names of channels whose structures have others: see `wrapped`.
    pub types: &'a [(&'a str, &'a str)],
    /// What the design is, for the manifests: "A ray-tracer datapath".
    pub purpose: &'a str,
    /// The parameters, for the comment at the head of each file.
    pub description: &'a str,
    /// The clock period of the constraints, in nanoseconds.
    pub period_ns: f64,
}

/// All files of a design around a datapath: each module in `rtl/`, listed in `<top>.f`, with the wrapper in
/// `<wrapper>.f`, in `<top>_wrapper.f` with a second wrapper, which has a structure for each channel of the top module,
/// and in a list of its name with a module beyond; all modules but the wrappers in `<top>.sv`, and the same without
/// package and structures in `<top>_plain.sv`; the assertions in `raypath_properties.sv`; `<top>.core` (FuseSoC) and
/// `Bender.yml`; and of the wrapper the constraints `<wrapper>.sdc` and `<wrapper>.xdc`, and `<wrapper>.xml` (IP-XACT).
///
/// # Errors
/// A design that cannot be printed: different modules of one name.
pub fn wrapped(design: Wrapped<'_>) -> Result<Files, Error> {
    let Wrapped { top, wrapper: axi, beyond, properties, types, purpose, description, period_ns } = design;
    let (banner, name) = (&banner(description), top.name());
    let own = format!("{name}_wrapper");
    let (wrapper_name, axi) = axi.map_or((own.as_str(), top), |axi| (axi.name(), axi));
    let Printed { names, all, .. } = Printed::of(top, banner)?;
    // Besides those of the top module.
    let Printed { mut files, names: of_wrapper, .. } = Printed::of(axi, banner)?;
    let wrapper: Vec<String> = of_wrapper.into_iter().filter(|path| !names.contains(path)).collect();
    let (all_file, checks) = (format!("{name}.sv"), "raypath_properties.sv");
    files.push((checks.into(), checkers(properties, &all_file, banner)));
    files.push((format!("{name}.f").into(), list(&names)));
    files.push((all_file.into(), all));
    files.push((format!("{name}_plain.sv").into(), plain(top, banner)?));
    let with_structures = Wrapper::of_channels(top, types).files(banner);
    let structured = paths(&with_structures);
    files.extend(with_structures);
    let of_axi = [&names[..], &wrapper].concat();
    if wrapper_name != own {
        files.push((format!("{wrapper_name}.f").into(), list(&of_axi)));
    }
    files.push((format!("{name}_wrapper.f").into(), list(&[&names[..], &structured].concat())));
    let mut further = Vec::new();
    for [module, doc, text] in beyond {
        let path = format!("rtl/{module}.sv");
        files.push((path.clone().into(), verilog::head(banner, std::slice::from_ref(doc)) + text));
        further.push(path);
    }
    if let Some([module, ..]) = beyond.last() {
        let below = of_axi.strip_suffix(&[format!("rtl/{wrapper_name}.sv")]).unwrap_or(&of_axi);
        files.push((format!("{module}.f").into(), list(&[below, &further].concat())));
    }
    let wrapper = [wrapper, structured, further].concat();
    let sources = Sources { name, description: purpose, modules: names, wrapper_name, wrapper, properties: checks };
    files.push((format!("{name}.core").into(), sources.fusesoc(banner)));
    files.push(("Bender.yml".into(), sources.bender(banner)));
    files.extend(soc::files(axi, &of_axi, purpose, banner, period_ns));
    Ok(files)
}

/// The first lines of each file.
fn banner(description: &str) -> Vec<String> {
    let version = env!("CARGO_PKG_VERSION");
    vec![format!("Generated by raypath {version}; do not edit."), format!("Configuration: {description}.")]
}

/// A module and all below it as SystemVerilog.
struct Printed {
    /// A file for each.
    files: Files,
    /// The paths of the files, in the order of compilation.
    names: Vec<String>,
    /// All in one text.
    all: String,
}

impl Printed {
    fn of(top: &Arc<Module>, banner: &[String]) -> Result<Self, Error> {
        let (mut files, mut names) = (Vec::new(), Vec::new());
        let license = format!("// {}\n//\n", verilog::LICENSE);
        let mut all = verilog::head(banner, top.doc());
        for (source, alone) in verilog::sources(top, banner)?.into_iter().zip(verilog::sources(top, &[])?) {
            let name = format!("rtl/{}.sv", source.name);
            all += &format!("{}\n", alone.text.trim_start_matches(&license));
            files.push((name.clone().into(), source.text));
            names.push(name);
        }
        Ok(Self { files, names, all })
    }
}

/// All modules in one text of words only, for tools that do not read types of packages.
fn plain(top: &Arc<Module>, banner: &[String]) -> Result<String, Error> {
    Ok(Printed::of(&text::plain(top), banner)?.all)
}

/// A list of files for `-f`.
fn list(names: &[String]) -> String {
    names.iter().map(|name| format!("{name}\n")).collect()
}

/// The file of these assertions, for simulation with the modules in the file `all`.
fn checkers(properties: &str, all: &str, banner: &[String]) -> String {
    let head = format!(
        "Assertions about the control of the pipeline. Compile this file after {all}, with assertions on (verilator \
         --assert). Its last lines bind the checkers to the modules. `raypath verify control` proves them."
    );
    verilog::head(banner, &[head]) + properties.trim_start()
}
