//! The linters that emitted SystemVerilog must pass without any message: Verilator, Yosys, slang and Icarus Verilog.

use crate::program::python;
use crate::verilator::VERILATOR;
use crate::yosys::YOSYS;
use crate::{Program, ToolError, read, write};
use raypath_hdl::verilog::CLOCK_GATE;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::process::Command;

static PYSLANG: Program = Program {
    name: "pyslang",
    expected: "Python's module pyslang 12 or newer",
    install: "python3 -m pip install pyslang",
    version: &["python3", "-c", "import pyslang, importlib.metadata as m; print('pyslang', m.version('pyslang'))"],
};

pub(crate) static ICARUS: Program = Program {
    name: "iverilog",
    expected: "Icarus Verilog 11 or newer",
    install: "apt-get install iverilog",
    version: &["iverilog", "-V"],
};

/// Parses and elaborates with every warning but one, which is off by default: that a signal is never read. Verilator
/// checks that too, and exempts names that say so.
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

/// Runs `verilator --lint-only -Wall` with `arguments` before the files.
///
/// # Errors
/// Verilator is missing, or reports an error or a warning.
pub fn lint_verilator(files: &[PathBuf], top: &str, arguments: &[&str]) -> Result<(), ToolError> {
    let mut command = Command::new("verilator");
    command.args(["--lint-only", "-Wall", "--top-module", top]).args(arguments).args(files);
    once(&VERILATOR, &[&["-Wall", top], arguments].concat(), files, || VERILATOR.output(&mut command))
}

/// Reads a file with Yosys and runs `check -assert` on it.
///
/// # Errors
/// The file cannot be read; Yosys is missing, reports an error or a warning, or infers a latch elsewhere than in a
/// clock gate.
pub fn lint_yosys(file: &Path, top: &str) -> Result<(), ToolError> {
    // Yosys warns of a selection in a module that does not exist.
    let text = std::fs::read_to_string(file).map_err(|problem| ToolError::file(file, "read", problem))?;
    let gates =
        if text.contains(&format!("module {CLOCK_GATE} ")) { format!(" {CLOCK_GATE}/* %d") } else { String::new() };
    let latches = format!("select -assert-none t:$dlatch{gates}");
    let script =
        format!("read_verilog -sv \"{}\"; hierarchy -check -top {top}; proc; check -assert; {latches}", file.display());
    let mut command = Command::new("yosys");
    let rules = script.replace(&file.display().to_string(), "");
    once(&YOSYS, &[&rules], &[file.to_path_buf()], || YOSYS.output(command.args(["-q", "-p", &script])))
}

/// Compiles files with slang, by its Python module.
///
/// # Errors
/// The module is missing, or slang reports any diagnostic.
pub fn lint_slang(files: &[PathBuf]) -> Result<(), ToolError> {
    let mut command = python();
    command.args(["-c", SLANG_SCRIPT]).args(files);
    once(&PYSLANG, &[SLANG_SCRIPT], files, || match PYSLANG.output(&mut command) {
        // The module, or a part that only later versions have, is missing.
        Err(ToolError::Failed { output, .. }) if output.starts_with("No module named 'pyslang") => {
            Err(ToolError::Missing(&PYSLANG))
        }
        other => other,
    })
}

/// Compiles a file with Icarus Verilog. Version 11 reads no types of packages: the file is one of words only
/// ([`plain`](raypath_hdl::text::plain)). It says of each `always_comb` that selects bits that all bits of the word are
/// in the list of sensitivities, which changes no result; such lines are ignored.
///
/// # Errors
/// Icarus Verilog is missing, or reports anything else.
pub fn lint_icarus(file: &Path, top: &str) -> Result<(), ToolError> {
    let mut command = Command::new("iverilog");
    command.args(["-g2012", "-t", "null", "-s", top]).arg(file);
    let is_other = |line: &&str| !line.ends_with(ALL_BITS_ARE_SENSITIVE);
    let output = || Ok(ICARUS.output(&mut command)?.lines().filter(is_other).collect());
    once(&ICARUS, &[ALL_BITS_ARE_SENSITIVE, top], &[file.to_path_buf()], output)
}

const ALL_BITS_ARE_SENSITIVE: &str =
    "sorry: constant selects in always_* processes are not currently supported (all bits will be included).";

/// Expects that a run prints nothing. Texts that passed are not read again if the environment variable
/// `RAYPATH_VERILATED` names a folder: a file there is named by a hash of the texts, the version, and `rules`, on which
/// the judgement depends besides.
fn once(
    program: &'static Program,
    rules: &[&str],
    files: &[PathBuf],
    run: impl FnOnce() -> Result<String, ToolError>,
) -> Result<(), ToolError> {
    let mut key = DefaultHasher::new();
    (program.version()?, rules).hash(&mut key);
    for file in files {
        (file.file_name(), read(file)?).hash(&mut key);
    }
    let passed = std::env::var_os("RAYPATH_VERILATED")
        .map(|folder| Path::new(&folder).join(format!("{:016x}-{}", key.finish(), program.name)));
    if passed.as_ref().is_some_and(|passed| passed.exists()) {
        return Ok(());
    }
    let output = run()?;
    if !output.trim().is_empty() {
        return Err(program.failed(output));
    }
    passed.map_or(Ok(()), |passed| write(&passed, ""))
}
