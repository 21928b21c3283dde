//! Projects of Vivado and Quartus: the text of a design, constraints, and a script that makes the project and runs it.

use raypath_hdl::Module;

/// A program for FPGAs that is not run here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Project {
    /// AMD Vivado.
    Vivado,
    /// Intel Quartus Prime.
    Quartus,
}

raypath_ops::names! {
    Project { Vivado = "vivado", Quartus = "quartus" },
    /// A text that names no program.
    ParseProjectError, "'{0}' is not a valid project, expected vivado or quartus"
}

impl Project {
    /// The names and contents of its files. `text` is that of the design with all its modules.
    pub fn files(self, top: &Module, text: &str, clock_mhz: f64) -> [(String, String); 3] {
        let period = (1e6 / clock_mhz).round() / 1000.0;
        let (script, constraints) = match self {
            Self::Vivado => (include_str!("vivado.tcl"), "xdc"),
            Self::Quartus => (include_str!("quartus.tcl"), "sdc"),
        };
        let filled = |template: &str| {
            let text = template.replace("@TOP@", top.name()).replace("@PERIOD@", &period.to_string());
            text.replace("@VERSION@", env!("CARGO_PKG_VERSION"))
        };
        let name = |ending: &str| format!("{}.{ending}", top.name());
        [
            (name("sv"), text.to_string()),
            (name(constraints), filled(include_str!("clock.sdc"))),
            ("project.tcl".to_string(), filled(script)),
        ]
    }
}
