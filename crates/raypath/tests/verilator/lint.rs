//! Three linters report nothing about any configuration, and the text contains no waiver.

use crate::verilator::representatives::REPRESENTATIVES;
use rayon::prelude::*;
use raypath::ops::Rules;
use raypath::rtl::{Config, Datapath, Encoding, Lanes, PRESETS};
use raypath_tools::{Sources, ToolError, lint_slang, lint_verilator, lint_yosys};
use std::process::Command;

type Linter = fn(&Sources) -> Result<(), ToolError>;

/// All three front ends, for every preset and for every value of every parameter.
#[test]
fn presets_and_representatives_are_clean() {
    let written: Vec<_> =
        presets_and_representatives().into_par_iter().map(|config| (config, sources(config))).collect();
    for (_, (_, sources)) in &written {
        let text = std::fs::read_to_string(&sources.all).expect("text");
        assert!(!text.contains("lint_off") && !text.contains("verilator"), "a waiver");
    }
    // A task for each linter, so that the largest configuration does not keep one core busy at the end.
    let linters: [Linter; 3] = [
        |sources| lint_verilator(&sources.files, "raypath", &[]),
        |sources| lint_yosys(&sources.all, "raypath"),
        |sources| lint_slang(std::slice::from_ref(&sources.all)),
    ];
    written.par_iter().flat_map_iter(|written| linters.map(|lint| (written, lint))).for_each(|(written, lint)| {
        let (config, (_, sources)) = written;
        lint(sources).unwrap_or_else(|fault| panic!("{config}: {fault}"));
    });
}

/// Verilator, the strictest linter, for all of Table VI except the configurations of the test above.
#[test]
#[ignore = "run by ./test.sh --long"]
fn all_of_table_vi_is_clean() {
    let linted = presets_and_representatives();
    table_vi().into_par_iter().filter(|config| !linted.contains(config)).for_each(|config| {
        let (_folder, sources) = sources(config);
        lint_verilator(&sources.files, "raypath", &[]).unwrap_or_else(|fault| panic!("{config}: {fault}"));
    });
}

fn presets_and_representatives() -> Vec<Config> {
    let presets = PRESETS.iter().map(|preset| preset.config);
    distinct(presets.chain([Config::DEFAULT.rules(Rules::Chisel)]).chain(REPRESENTATIVES))
}

fn table_vi() -> Vec<Config> {
    let encodings = Encoding::ALL.iter().flat_map(|&io| Encoding::ALL.iter().map(move |&registers| (io, registers)));
    let of =
        |(io, registers)| Lanes::ALL.iter().map(move |&lanes| Config::DEFAULT.io(io).registers(registers).lanes(lanes));
    let all: Vec<Config> = encodings.flat_map(of).collect();
    assert_eq!(all.len(), 28);
    all
}

fn distinct(configs: impl Iterator<Item = Config>) -> Vec<Config> {
    let mut distinct = Vec::new();
    for config in configs {
        if !distinct.contains(&config) {
            distinct.push(config);
        }
    }
    distinct
}

fn sources(config: Config) -> (tempfile::TempDir, Sources) {
    let datapath = Datapath::new(config).expect("a datapath");
    let folder = tempfile::tempdir().expect("a folder");
    let sources = Sources::write(datapath.top(), folder.path()).expect("sources");
    (folder, sources)
}

/// All three linters on the files that `generate` lists.
#[test]
fn the_files_of_generate_are_clean() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut generate = Command::new(env!("CARGO_BIN_EXE_raypath"));
    let output = generate.args(["generate", "--jobs", "1", "--out"]).arg(folder.path()).output().expect("the program");
    assert!(output.status.success(), "{output:?}");
    let list = std::fs::read_to_string(folder.path().join("raypath.f")).expect("the list");
    let files: Vec<_> = list.lines().map(|file| folder.path().join(file)).collect();
    lint_verilator(&files, "raypath", &[]).expect("clean files");
    let all = folder.path().join("raypath.sv");
    lint_verilator(std::slice::from_ref(&all), "raypath", &["-Wno-DECLFILENAME"]).expect("a clean file");
    lint_yosys(&all, "raypath").expect("a clean file");
    lint_slang(std::slice::from_ref(&all)).expect("a clean file");
    let bound = [all, folder.path().join("raypath_properties.sv")];
    lint_verilator(&bound, "raypath", &["--assert", "-Wno-DECLFILENAME"]).expect("clean assertions");
    lint_slang(&bound).expect("clean assertions");
}

/// Negative control: each linter reports a fault.
#[test]
fn linters_report_a_fault() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("a file");
        path
    };
    let unused = file("unused.sv", "module unused (input logic a_i);\nendmodule\n");
    assert!(lint_verilator(&[unused], "unused", &[]).is_err());
    let latch = file(
        "latch.sv",
        "module latch (input logic a_i, input logic b_i, output logic c_o);\n  always_latch if (a_i) c_o = b_i;\nendmodule\n",
    );
    assert!(lint_yosys(&latch, "latch").is_err());
    let cycle = file(
        "cycle.sv",
        "module cycle (output logic c_o);\n  logic d;\n  assign d = ~c_o;\n  assign c_o = d;\nendmodule\n",
    );
    assert!(lint_yosys(&cycle, "cycle").is_err());
    let undeclared = file("undeclared.sv", "module undeclared (output logic c_o);\n  assign c_o = d;\nendmodule\n");
    assert!(lint_slang(&[undeclared]).is_err());
}
