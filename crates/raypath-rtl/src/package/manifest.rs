//! Lists of files for simulators and package managers.

use crate::package::text::yaml_head;

/// The version that manifests name.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The files of a design, in the order in which they are compiled, by their paths beside the manifests.
#[derive(Debug)]
pub struct Sources<'a> {
    /// The name of the top module.
    pub name: &'a str,
    /// What it is.
    pub description: &'a str,
    /// The package of the datapath, and the top module and all below it.
    pub modules: Vec<String>,
    /// The name of the wrapper.
    pub wrapper_name: &'a str,
    /// The wrapper, and its package if it has one.
    pub wrapper: Vec<String>,
    /// The assertions.
    pub properties: &'a str,
}

impl Sources<'_> {
    /// A list for `-f`: modules, package and wrapper.
    pub fn list(&self) -> String {
        self.modules.iter().chain(&self.wrapper).map(|file| format!("{file}\n")).collect()
    }

    /// A core file for FuseSoC. Dependent cores get modules, package and wrapper.
    pub fn fusesoc(&self, banner: &[String]) -> String {
        let Self { name, description, wrapper_name, properties, .. } = self;
        let fileset = |name: &str, files: &[String]| {
            format!("  {name}:\n    files:\n{}    file_type: systemVerilogSource\n", items("      ", files))
        };
        let comment = yaml_head(banner);
        let filesets = [
            fileset("rtl", &self.modules),
            fileset("wrapper", &self.wrapper),
            fileset("properties", &[properties.to_string()]),
        ];
        let targets = [
            format!("  default:\n    filesets: [rtl, wrapper]\n    toplevel: {wrapper_name}\n"),
            format!(
                "  lint:\n    filesets: [rtl, wrapper, properties]\n    toplevel: {wrapper_name}\n    flow: lint\n"
            ),
            // Verilator warns about several modules in a file, as the assertions have them.
            "    flow_options:\n      tool: verilator\n      verilator_options: [-Wall, --assert, -Wno-DECLFILENAME]\n"
                .to_string(),
        ];
        format!(
            "CAPI=2:\n{comment}name: ::{name}:{VERSION}\ndescription: {description}\n\nfilesets:\n{}\ntargets:\n{}",
            filesets.concat(),
            targets.concat(),
        )
    }

    /// A manifest for Bender. The assertions are for its target `simulation`.
    pub fn bender(&self, banner: &[String]) -> String {
        let Self { name, description, properties, .. } = self;
        let files: Vec<String> = self.modules.iter().chain(&self.wrapper).cloned().collect();
        format!(
            "{}package:\n  name: {name}\n  description: {description}\n\nsources:\n{}  - target: simulation\n    \
             files:\n{}",
            yaml_head(banner),
            items("  ", &files),
            items("      ", &[properties.to_string()]),
        )
    }
}

/// A YAML list. Paths consist of identifiers and need no quotes.
fn items(indent: &str, files: &[String]) -> String {
    files.iter().map(|file| format!("{indent}- {file}\n")).collect()
}
