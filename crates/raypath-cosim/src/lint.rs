//! The three tools that must accept what is emitted, without a word.

use crate::CosimError;
use crate::tool;
use crate::verilated::VERILATOR;
use std::path::{Path, PathBuf};
use std::process::Command;

const PYSLANG: &str = "pip install pyslang";

/// Parses and elaborates with every warning that there is but one, off by default: that a signal is never read.
/// Verilator says so too, and excepts the names that say it themselves.
const SLANG_SCRIPT: &str = r#"
import sys
try:
    import pyslang
    from pyslang.driver import Driver
except ImportError as problem:
    sys.exit(problem.msg)
driver = Driver()
driver.addStandardArgs()
arguments = ["slang", "-Weverything", "-Wno-unused-but-set-variable", "-Werror"] + sys.argv[1:]
quoted = " ".join('"' + a.replace("\\", "\\\\").replace('"', '\\"') + '"' for a in arguments)
accepted = driver.parseCommandLine(quoted) and driver.processOptions() and driver.parseAllSources()
accepted = accepted and driver.runFullCompilation(True)
sys.exit(0 if accepted else 1)
"#;

/// `verilator --lint-only -Wall`, with `arguments` before the files: no error, no warning.
pub fn lint_verilator(files: &[PathBuf], top: &str, arguments: &[&str]) -> Result<(), CosimError> {
    let mut command = Command::new("verilator");
    command.args(["--lint-only", "-Wall", "--top-module", top]).args(arguments).args(files);
    silent("verilator", tool::run(&mut command, VERILATOR)?)
}

/// Yosys reads it, finds every module, and `check -assert` finds no fault; no warning, no latch.
pub fn lint_yosys(file: &Path, top: &str) -> Result<(), CosimError> {
    let script = format!(
        "read_verilog -sv \"{}\"; hierarchy -check -top {top}; proc; check -assert; select -assert-none t:$dlatch",
        file.display()
    );
    let mut command = Command::new("yosys");
    silent("yosys", tool::run(command.args(["-q", "-p", &script]), "apt-get install yosys")?)
}

/// slang, through its Python package: no diagnostic of any kind.
pub fn lint_slang(files: &[PathBuf]) -> Result<(), CosimError> {
    let mut command = Command::new("python3");
    command.args(["-c", SLANG_SCRIPT]).args(files);
    match tool::run(&mut command, "apt-get install python3") {
        Ok(output) => silent("slang", output),
        // Of the package, or of a part that only its later versions have.
        Err(CosimError::Tool { output, .. }) if output.starts_with("No module named 'pyslang") => {
            Err(CosimError::MissingTool { tool: "pyslang".to_string(), install: PYSLANG })
        }
        Err(CosimError::Tool { output, .. }) => Err(CosimError::Tool { tool: "slang".to_string(), output }),
        Err(other) => Err(other),
    }
}

fn silent(tool: &str, output: String) -> Result<(), CosimError> {
    if output.trim().is_empty() { Ok(()) } else { Err(CosimError::Tool { tool: tool.to_string(), output }) }
}
