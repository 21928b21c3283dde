//! `raypath generate --unit`.

use crate::{contents, ends_with, folder, printed, raypath, said, text};
use raypath_tools::{lint_slang, lint_verilator, lint_yosys};
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::Command;

#[test]
fn the_unit_is_written_listed_and_checked() {
    let folder = folder();
    let out = text(folder.path());
    let options = "--unit --contexts 12 --stack 2 --memory-width 256 --id-width 20 --divider-latency 3 --rays 200";
    let arguments: Vec<&str> =
        ["generate", "--preset", "compact", "--out", &out].into_iter().chain(options.split(' ')).collect();
    let output = raypath(&arguments);
    let said = said(&output);
    assert_eq!(output.status.code(), Some(0), "{said}");
    for words in ["contexts 12, stack 2, memory-width 256", "hit_id_o [19:0]", "mem_rsp_data_i [255:0]", "Checked 200"]
    {
        assert!(said.contains(words), "no '{words}' in {said}");
    }
    assert!(said.contains("\n0 mismatches between netlist, cycle-exact and functional model."), "{said}");
    // A stack of two groups of 195 bits for each context.
    assert_eq!(printed(&said, "| u_walk.u_stack ").split('|').nth(3).map(str::trim), Some("4680"), "{said}");

    let files = contents(folder.path());
    let of = |name: &str| {
        let (_, bytes) = files.iter().find(|(known, _)| known == name).unwrap_or_else(|| panic!("no {name}"));
        String::from_utf8(bytes.clone()).expect("text")
    };
    let modules: BTreeSet<&str> =
        files.iter().map(|(name, _)| name.as_str()).filter(|name| name.starts_with("rtl/")).collect();
    let (list, with_axi) = (of("raypath_unit.f"), of("raypath_unit_axi.f"));
    let listed: Vec<&str> = with_axi.lines().collect();
    assert_eq!(listed.iter().copied().collect::<BTreeSet<_>>(), modules);
    assert_eq!(listed.len(), modules.len(), "a module is listed twice");
    assert_eq!(with_axi, format!("{list}rtl/raypath_unit_axi.sv\n"));
    assert_eq!(list.lines().last(), Some("rtl/raypath_unit.sv"));
    for manifest in ["raypath_unit.core", "Bender.yml"] {
        let manifest = of(manifest);
        let named = manifest.lines().filter_map(|line| line.trim().strip_prefix("- "));
        let named: Vec<&str> = named.filter(|name| name.ends_with(".sv")).collect();
        assert_eq!(named[..listed.len()], listed);
        assert_eq!(named[listed.len()..], ["raypath_properties.sv"]);
    }
    let all = of("raypath_unit.sv");
    for (name, bytes) in &files {
        let text = String::from_utf8_lossy(bytes);
        if name.ends_with(".sv") {
            assert!(text.starts_with("// SPDX-License-Identifier: MIT OR Apache-2.0\n"), "{name}");
            assert!(text.lines().all(|line| line.len() <= 100), "{name}");
        }
        if let Some(module) = name.strip_prefix("rtl/").and_then(|name| name.strip_suffix(".sv")) {
            let is_there =
                all.contains(&format!("\nmodule {module} ")) || all.contains(&format!("\npackage {module};"));
            assert_eq!(is_there, module != "raypath_unit_axi", "{name}");
        }
    }

    let paths: Vec<PathBuf> = listed.iter().map(|name| folder.path().join(name)).collect();
    let checked: Vec<PathBuf> = paths.iter().cloned().chain([folder.path().join("raypath_properties.sv")]).collect();
    lint_verilator(&paths, "raypath_unit_axi", &[]).expect("no report of Verilator");
    lint_verilator(&checked, "raypath_unit_axi", &["--assert", "-Wno-DECLFILENAME"]).expect("nor with assertions");
    lint_yosys(&folder.path().join("raypath_unit.sv"), "raypath_unit").expect("no report of Yosys");
    lint_slang(&paths).expect("no report of slang");
    let fusesoc = ["--cores-root", ".", "run", "--target=lint", "raypath_unit"];
    let output = Command::new("fusesoc").args(fusesoc).current_dir(folder.path()).output().expect("fusesoc");
    assert!(output.status.success(), "{}", crate::said(&output));
}

#[test]
fn wrong_parameters_of_the_unit_are_named() {
    let wrong: [(&str, &[&str]); 12] = [
        ("--unit --contexts 7", &["'7'", "--contexts", "expected 8 to 256"]),
        ("--unit --contexts many", &["'many'", "expected 8 to 256"]),
        ("--unit --stack 3", &["'3'", "--stack", "expected 2, 4, 8, 16 or 32"]),
        ("--unit --memory-width 64", &["'64'", "--memory-width", "expected 128, 256, 512 or 1024"]),
        ("--unit --id-width 65", &["'65'", "--id-width", "expected 1 to 64"]),
        ("--unit --divider-latency 0", &["'0'", "--divider-latency", "expected 1 to 27"]),
        ("--unit --rays 0", &["'0'", "--rays", "expected a whole number from 1"]),
        ("--contexts 8", &["--unit"]),
        ("--unit --with sphere", &["--unit", "cannot be used with", "--with"]),
        ("--unit --jobs 5", &["--unit", "cannot be used with", "--jobs"]),
        ("--unit --preset half", &["format e5s11", "expected format fp32"]),
        ("--unit --rules chisel", &["rules chisel", "expected rules paper"]),
    ];
    for (options, words) in wrong {
        let arguments: Vec<&str> = ["generate"].into_iter().chain(options.split(' ')).collect();
        ends_with(&arguments, 2, words);
    }
}
