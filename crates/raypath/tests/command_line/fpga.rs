//! `raypath fpga`: missing programs, wrong input, and a board that does not answer.

use crate::command_line::{ends_with, file, folder, program_ends_with};
use std::process::Command;

#[test]
fn wrong_options_are_named_with_what_was_expected() {
    ends_with(
        &["fpga", "--device", "ecp5-12k"],
        2,
        &["'ecp5-12k'", "expected ecp5-25k, ecp5-45k, ecp5-85k, xilinx-7 or"],
    );
    ends_with(&["fpga", "--speed", "9"], 2, &["'9'", "--speed", "expected a whole number from 6 to 8"]);
    ends_with(&["fpga", "--seeds", "0"], 2, &["'0'", "--seeds", "expected a whole number from 1 to 1000"]);
    ends_with(&["fpga", "--project", "ise"], 2, &["'ise'", "expected vivado or quartus"]);
    ends_with(&["fpga", "--contexts", "8"], 2, &["--contexts", "expected --unit"]);
    ends_with(&["fpga", "--clock", "0"], 2, &["'0'", "--clock", "expected MHz, 1 to 1000"]);
    ends_with(&["fpga", "--stream", "16"], 2, &["'16'", "--stream", "8, 32"]);
    ends_with(&["fpga", "--multiplier", "fast"], 2, &["'fast'", "multiplier", "booth, inferred or dsp"]);
    ends_with(&["fpga", "--loopback", "--connect", "x"], 2, &["--loopback", "--connect"]);
}

#[test]
fn missing_tools_are_named_with_their_packages() {
    let folder = folder();
    let mut program = Command::new(env!("CARGO_BIN_EXE_raypath"));
    program.args(["fpga", "--preset", "half"]).current_dir(folder.path()).env("PATH", folder.path());
    program_ends_with(&mut program, 2, &["yosys not found", "apt-get install yosys"]);
    assert!(!folder.path().join("build").exists());
}

/// A plain file keeps the jobs, which are no outcomes when they are read again.
#[test]
fn outcomes_that_do_not_come_are_an_error() {
    let folder = folder();
    let board = file(folder.path(), "board", "");
    let connect = ["fpga", "--format", "e3s3", "--lanes", "none", "--jobs", "3", "--connect"];
    let missing = folder.path().join("none");
    let missing = missing.to_str().expect("a plain path");
    ends_with(&[&connect[..], &[missing]].concat(), 2, &[missing, "cannot write"]);
    ends_with(&[&connect[..], &[&board]].concat(), 1, &["of 3 outcomes are wrong or missing"]);
    let kept = file(folder.path(), "kept", "text");
    ends_with(&[&connect[..], &[&kept]].concat(), 2, &[&kept, "a file, which jobs would overwrite, expected a device"]);
    assert_eq!(std::fs::read_to_string(&kept).expect("a file"), "text");
}

/// A project names its files, its module and the period of `--clock`.
#[test]
fn projects_have_the_text_constraints_and_a_script() {
    let folder = folder();
    for (project, constraints, command) in [("vivado", "xdc", "launch_runs impl_1"), ("quartus", "sdc", "execute_flow")]
    {
        let out = folder.path().join(project);
        let given = ["fpga", "--format", "e3s3", "--lanes", "none", "--clock", "125", "--project", project, "--out"];
        ends_with(&[&given[..], &[out.to_str().expect("a name")]].concat(), 0, &["Not run here"]);
        let read = |name: &str| std::fs::read_to_string(out.join(name)).expect("a file");
        assert!(read("raypath.sv").contains("\nmodule raypath"));
        assert!(read(&format!("raypath.{constraints}")).contains("-period 8 [get_ports clk_i]"));
        let script = read("project.tcl");
        assert!(script.contains(command) && script.contains("raypath.sv") && !script.contains('@'), "{script}");
    }
}
