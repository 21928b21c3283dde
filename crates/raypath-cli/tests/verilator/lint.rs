//! Four linters report nothing about any configuration, and the text contains no waiver.

use crate::verilator::representatives::REPRESENTATIVES;
use rayon::prelude::*;
use raypath_hdl::text::plain;
use raypath_ops::Culling;
use raypath_rtl::{Accumulators, Config, DatapathNetlist, Encoding, Lanes, PRESETS};
use raypath_tools::{Sources, ToolError, lint_icarus, lint_slang, lint_verilator, lint_yosys};
use std::path::{Path, PathBuf};

/// A design in both texts.
struct Written {
    _folder: tempfile::TempDir,
    sources: Sources,
    plain: PathBuf,
}

type Linter = fn(&Written) -> Result<(), ToolError>;

/// All four front ends, for every value of every parameter.
#[test]
fn representatives_are_clean() {
    all_linters_are_silent(representatives());
}

#[test]
#[ignore = "run by ./test.sh --long"]
fn presets_are_clean() {
    all_linters_are_silent(PRESETS.iter().map(|preset| preset.config).collect());
}

fn all_linters_are_silent(configs: Vec<Config>) {
    let written: Vec<_> = configs.into_par_iter().map(|config| (config, written(config))).collect();
    for (_, design) in &written {
        let text = std::fs::read_to_string(&design.sources.all).expect("text");
        assert!(!text.contains("lint_off") && !text.contains("verilator"), "a waiver");
    }
    // A task for each linter, so that the largest configuration does not keep one core busy at the end.
    let linters: [Linter; 4] = [
        |design| lint_verilator(&design.sources.files, "raypath", &[]),
        |design| lint_yosys(&design.sources.all, "raypath"),
        |design| lint_slang(std::slice::from_ref(&design.sources.all)),
        |design| lint_icarus(&design.plain, "raypath"),
    ];
    written.par_iter().flat_map_iter(|written| linters.map(|lint| (written, lint))).for_each(|(written, lint)| {
        let (config, design) = written;
        lint(design).unwrap_or_else(|fault| panic!("{config}: {fault}"));
    });
}

/// Verilator, the strictest linter, for all of Table VI.
#[test]
#[ignore = "run by ./test.sh --long"]
fn all_of_table_vi_is_clean() {
    table_vi().into_par_iter().for_each(|config| {
        let design = written(config);
        lint_verilator(&design.sources.files, "raypath", &[]).unwrap_or_else(|fault| panic!("{config}: {fault}"));
    });
}

/// Configurations with every value of every parameter, and one with all features. More lanes than 16 repeat the text of
/// fewer.
fn representatives() -> Vec<Config> {
    let small = Config::DEFAULT.lanes(Lanes::Two).accumulators(Accumulators::Four);
    let triangles = small.barycentrics(true).culling(Culling::None).facing(true).range(true);
    let features = triangles.tag(8).conservative(true).exception_flags(true);
    let few_lanes = REPRESENTATIVES.into_iter().filter(|config| config.semantics.lanes.count() <= 16);
    [Config::DEFAULT, features].into_iter().chain(few_lanes).collect()
}

fn table_vi() -> Vec<Config> {
    let encodings = Encoding::ALL.iter().flat_map(|&io| Encoding::ALL.iter().map(move |&registers| (io, registers)));
    let of =
        |(io, registers)| Lanes::ALL.iter().map(move |&lanes| Config::DEFAULT.io(io).registers(registers).lanes(lanes));
    let all: Vec<Config> = encodings.flat_map(of).collect();
    assert_eq!(all.len(), 28);
    all
}

fn written(config: Config) -> Written {
    let datapath = DatapathNetlist::new(config).expect("a datapath");
    let folder = tempfile::tempdir().expect("a folder");
    let sources = Sources::write(datapath.top(), folder.path()).expect("sources");
    let own = folder.path().join("plain");
    std::fs::create_dir(&own).expect("a folder");
    let plain = Sources::write(&plain(datapath.top()), &own).expect("plain sources").all;
    Written { _folder: folder, sources, plain }
}

/// Runs `generate` into a folder.
fn generate(arguments: &[&str], folder: &Path) {
    let folder = folder.to_str().expect("a name in UTF-8");
    let line = ["raypath", "generate", "--out", folder].into_iter().chain(arguments.iter().copied());
    assert_eq!(raypath_cli::run(line), 0, "{arguments:?}");
}

/// The files in a list that `generate` writes.
fn listed(folder: &Path, list: &str) -> Vec<PathBuf> {
    let list = std::fs::read_to_string(folder.join(list)).expect("the list");
    list.lines().map(|file| folder.join(file)).collect()
}

/// All linters on the files that `generate` writes.
#[test]
fn the_files_of_generate_are_clean() {
    let designs = [(&["--jobs", "1"][..], "raypath"), (&["--unit", "--rays", "1"], "raypath_unit")];
    for (arguments, top) in designs {
        let folder = tempfile::tempdir().expect("a folder");
        generate(arguments, folder.path());
        lint_verilator(&listed(folder.path(), &format!("{top}.f")), top, &[]).expect("clean files");
        let all = folder.path().join(format!("{top}.sv"));
        lint_yosys(&all, top).expect("a clean file");
        let plain = folder.path().join(format!("{top}_plain.sv"));
        lint_verilator(std::slice::from_ref(&plain), top, &["-Wno-DECLFILENAME"]).expect("a clean file");
        lint_icarus(&plain, top).expect("a clean file");
        let bound = [all, folder.path().join("raypath_properties.sv")];
        lint_verilator(&bound, top, &["--assert", "-Wno-DECLFILENAME"]).expect("clean assertions");
        lint_slang(&bound).expect("clean assertions");
    }
}

/// Two datapaths, and a traversal unit around a third, in one module with their assertions.
#[test]
fn designs_of_different_prefixes_fit_in_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let designs: [(&str, &str, &[&str]); 3] = [
        ("first", "first_wrapper", &["--jobs", "1", "--preset", "half"]),
        ("second", "second_wrapper", &["--jobs", "1", "--preset", "credit", "--lanes", "2"]),
        ("third", "third_unit_axi", &["--rays", "1", "--unit", "--contexts", "8"]),
    ];
    let (mut files, mut ports, mut instances) = (Vec::new(), Vec::new(), String::new());
    for (prefix, top, arguments) in designs {
        let own = folder.path().join(prefix);
        generate(&[arguments, &["--prefix", prefix]].concat(), &own);
        files.extend(listed(&own, &format!("{top}.f")));
        files.push(own.join(format!("{prefix}_properties.sv")));
        let text = std::fs::read_to_string(own.join(format!("rtl/{top}.sv"))).expect("the top module");
        // The ports follow the parameters, if there are any.
        let header = text.split_once(&format!("module {top} ")).and_then(|(_, rest)| rest.split_once("\n);"));
        let header = header.map(|(header, _)| header.rsplit_once("(\n").unwrap_or_default().1);
        let mut connections = Vec::new();
        let ports_of =
            header.expect("ports").lines().map(|line| line.split("//").next().unwrap_or_default().trim_end());
        for port in ports_of.filter(|line| !line.is_empty()) {
            let (kind, name) = port.trim_end_matches(',').rsplit_once(' ').expect("a type and a name");
            let defaults =
                [("IdWidth", "16"), ("Units", "1"), ("TagWidth", "3"), ("ArUserWidth", "1"), ("AddressWidth", "32")];
            let kind = defaults.iter().fold(kind.to_string(), |kind, (name, value)| kind.replace(name, value));
            ports.push(format!("{kind} {prefix}_{name}"));
            connections.push(format!("    .{name} ({prefix}_{name})"));
        }
        instances += &format!("  {top} u_{prefix} (\n{}\n  );\n", connections.join(",\n"));
    }
    let several = folder.path().join("several.sv");
    let text = format!("module several (\n{}\n);\n{instances}endmodule\n", ports.join(",\n"));
    std::fs::write(&several, text).expect("a file");
    files.push(several);
    lint_verilator(&files, "several", &["--assert", "-Wno-DECLFILENAME"]).expect("clean files");
    lint_slang(&files).expect("clean files");
    for file in &files {
        let text = std::fs::read_to_string(file).expect("text");
        assert!(!text.contains("raypath_"), "{}: a name that begins with raypath", file.display());
    }
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
    assert!(lint_icarus(&undeclared, "undeclared").is_err());
    assert!(lint_slang(&[undeclared]).is_err());
}
