//! The cocotb example passes on the printed text.

use crate::package::folder::{preset, write};
use std::path::Path;
use std::process::Command;

#[test]
fn the_example_passes() {
    let datapath = preset("original");
    let written = write(&datapath);
    // The list `raypath.f` of `generate`: the modules only.
    let listed = written.text("raypath_wrapper.f").lines().filter(|file| !file.ends_with("_wrapper_pkg.sv"));
    let modules = listed.filter(|file| !file.ends_with("_wrapper.sv")).map(|file| format!("{file}\n"));
    std::fs::write(written.path().join("raypath.f"), modules.collect::<String>()).expect("a list");

    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/cocotb/run.py");
    let mut python = Command::new("python3");
    let output = python.env("SIM", "verilator").arg(script).arg(written.path()).output().expect("python3");
    let said = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(!said.contains("No module named 'cocotb"), "cocotb not found; install it with: pip install 'cocotb<2'");
    assert!(output.status.success() && said.contains("TESTS=3 PASS=3 FAIL=0"), "{said}");
}
