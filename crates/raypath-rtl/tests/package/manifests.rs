//! The list and the manifests name the existing files. FuseSoC reads its core file, and a YAML parser Bender's
//! manifest.

use crate::package::folder::{Written, preset, write};
use raypath_tools::lint_verilator;
use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Output};

/// Runs a program that `pip install` provides.
fn run(program: &str, install: &str, arguments: &[&str], folder: &Path) -> Output {
    let output = Command::new(program).args(arguments).current_dir(folder).output();
    output.unwrap_or_else(|problem| panic!("{program}: {problem}; install it with: pip install {install}"))
}

/// Every SystemVerilog file in the folder, and no other, is in the list, in the core file and in Bender's manifest.
#[test]
fn every_file_is_listed_once() {
    let written = write(&preset("graphics"));
    let mut there: BTreeSet<String> = ["raypath_properties.sv".to_string()].into();
    for entry in std::fs::read_dir(written.path().join("rtl")).expect("a folder") {
        there.insert(format!("rtl/{}", entry.expect("a file").file_name().to_str().expect("a name")));
    }
    for name in ["raypath.core", "Bender.yml"] {
        let lines = written.text(name).lines().filter_map(|line| line.trim().strip_prefix("- "));
        let files: Vec<&str> = lines.filter(|line| line.ends_with(".sv")).collect();
        assert_eq!(files.len(), there.len(), "{name}");
        assert_eq!(files.iter().map(|file| file.to_string()).collect::<BTreeSet<_>>(), there, "{name}");
        // In the order of compilation.
        let listed: Vec<&str> = written.text("raypath_wrapper.f").lines().collect();
        assert_eq!(files[..listed.len()], listed, "{name}");
    }
}

/// The target `lint` of the core file, with assertions.
#[test]
fn fusesoc_runs_its_lint() {
    let written = write(&preset("credit"));
    let output = fusesoc(&written);
    let said = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{said}");
    assert!(!said.contains("WARNING") && !said.contains("%Warning"), "{said}");
}

/// The core file lists the compiled files: without one of them, the build fails.
#[test]
fn fusesoc_misses_a_file() {
    let written = write(&preset("graphics"));
    std::fs::remove_file(written.path().join("rtl/raypath_wrapper_pkg.sv")).expect("a file less");
    assert!(!fusesoc(&written).status.success());
}

fn fusesoc(written: &Written) -> Output {
    let arguments = ["--cores-root", ".", "run", "--target=lint", "raypath"];
    run("fusesoc", "fusesoc", &arguments, written.path())
}

/// Bender's manifest is YAML in the documented form, and the assertions are in its group `simulation`.
#[test]
fn bender_has_its_sources() {
    let written = write(&preset("half"));
    let script = "import sys, yaml\n\
        manifest = yaml.safe_load(open('Bender.yml'))\n\
        assert set(manifest) == {'package', 'sources'}, manifest\n\
        assert manifest['package'].keys() <= {'name', 'description', 'authors'}, manifest\n\
        for source in manifest['sources']:\n    \
            group = source if isinstance(source, dict) else {'files': [source]}\n    \
            assert group.keys() <= {'target', 'files'} and isinstance(group.get('target', ''), str), group\n    \
            for file in group['files']: print(file)\n";
    let output = run("python3", "pyyaml", &["-c", script], written.path());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("text");
    let files: Vec<_> = text.lines().map(|file| written.path().join(file)).collect();
    lint_verilator(&files, "raypath_wrapper", &["--assert", "-Wno-DECLFILENAME"])
        .unwrap_or_else(|fault| panic!("{fault}"));
}
