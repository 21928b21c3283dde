//! Which files there are, for simulators and for package managers.

use crate::text::head;

/// The version that manifests name.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The files of a datapath, in the order in which they are compiled, by their paths beside the manifests.
#[derive(Debug)]
pub struct Sources<'a> {
    /// The name of the top module.
    pub name: &'a str,
    /// The top module and all below it.
    pub modules: Vec<String>,
    /// Package and wrapper.
    pub wrapper: Vec<String>,
}

impl Sources<'_> {
    /// A list for `-f`: modules, package and wrapper.
    pub fn list(&self) -> String {
        self.modules.iter().chain(&self.wrapper).map(|file| format!("{file}\n")).collect()
    }

    /// A core file for FuseSoC. What depends on it gets modules, package and wrapper.
    pub fn fusesoc(&self, banner: &[String]) -> String {
        let Self { name, .. } = self;
        let fileset = |name: &str, files: &[String]| {
            format!("  {name}:\n    files:\n{}    file_type: systemVerilogSource\n", items("      ", files))
        };
        let comment = head("#", banner, &[]);
        let filesets = [
            fileset("rtl", &self.modules),
            fileset("wrapper", &self.wrapper),
            fileset("properties", &[self.properties()]),
        ];
        format!(
            "CAPI=2:\n{comment}name: ::{name}:{VERSION}\ndescription: A ray-tracer datapath\n\nfilesets:\n{}\ntargets:\n  \
             default:\n    filesets: [rtl, wrapper]\n    toplevel: {name}_wrapper\n  lint:\n    default_tool: verilator\n    \
             filesets: [rtl, wrapper, properties]\n    toplevel: {name}_wrapper\n    tools:\n      verilator:\n        mode: \
             lint-only\n        verilator_options: [-Wall, --assert]\n",
            filesets.concat(),
        )
    }

    /// A manifest for Bender. The assertions are for its target `simulation`.
    pub fn bender(&self, banner: &[String]) -> String {
        let Self { name, .. } = self;
        let files: Vec<String> = self.modules.iter().chain(&self.wrapper).cloned().collect();
        format!(
            "{}package:\n  name: {name}\n  description: A ray-tracer datapath\n\nsources:\n{}  - target: simulation\n    \
             files:\n{}",
            head("#", banner, &[]),
            items("  ", &files),
            items("      ", &[self.properties()]),
        )
    }

    /// The assertions, which `raypath generate` writes beside the manifests.
    fn properties(&self) -> String {
        format!("{}_properties.sv", self.name)
    }
}

/// A YAML list. Paths are made of identifiers, so nothing needs quotes.
fn items(indent: &str, files: &[String]) -> String {
    files.iter().map(|file| format!("{indent}- {file}\n")).collect()
}
