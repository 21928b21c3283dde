//! `raypath generate --unit`.

use crate::command_line::{contents, ends_with, file, folder, page, printed, raypath, said, text};
use raypath_tools::{lint_slang, lint_verilator, lint_yosys};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

#[test]
fn the_unit_is_written_listed_and_checked() {
    let folder = folder();
    let out = text(folder.path());
    let options = "--unit --contexts 12 --stack 2 --memory-width 256 --id-width 7 --divider-latency 3 --rays 200";
    let arguments: Vec<&str> =
        ["generate", "--preset", "compact", "--out", &out].into_iter().chain(options.split(' ')).collect();
    let output = raypath(&arguments);
    let said = said(&output);
    assert_eq!(output.status.code(), Some(0), "{said}");
    for words in
        ["12 contexts, stacks of 2, memory of 256 bits", "hit_id_o [6:0]", "mem_rsp_data_i [255:0]", "Checked 200"]
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
    let with_structures = of("raypath_unit_wrapper.f");
    let structured = ["rtl/raypath_unit_wrapper_pkg.sv", "rtl/raypath_unit_wrapper.sv"];
    assert_eq!(with_structures, format!("{list}{}\n", structured.join("\n")));
    let of_device = ["device_registers", "rings", "device"].map(|name| format!("rtl/raypath_{name}.sv"));
    let device = with_axi.replace("rtl/raypath_unit_axi.sv\n", &(of_device.join("\n") + "\n"));
    assert_eq!(of("raypath_device.f"), device);
    let listed: Vec<&str> = listed.into_iter().chain(structured).chain(of_device.iter().map(String::as_str)).collect();
    assert_eq!(listed.iter().copied().collect::<BTreeSet<_>>(), modules);
    assert_eq!(listed.len(), modules.len(), "a module is listed twice");
    let of_axi = ["arbiter", "cache", "cluster", "guard", "unit_axi"].map(|name| format!("rtl/raypath_{name}.sv\n"));
    assert_eq!(with_axi, list.clone() + &of_axi.concat());
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
            assert_eq!(is_there, list.lines().any(|listed| listed == name), "{name}");
        }
    }

    let checked = listed.iter().copied().chain(["raypath_properties.sv"]);
    let checked: Vec<PathBuf> = checked.map(|name| folder.path().join(name)).collect();
    lint_verilator(&checked, "raypath_unit_axi", &["--assert", "-Wno-DECLFILENAME"]).expect("no report");
    let fusesoc = ["--cores-root", ".", "run", "--target=lint", "raypath_unit"];
    let output = Command::new("fusesoc").args(fusesoc).current_dir(folder.path()).output().expect("fusesoc");
    assert!(output.status.success(), "{}", crate::command_line::said(&output));
}

#[test]
fn wrong_parameters_of_the_unit_are_named() {
    let wrong: [(&str, &[&str]); 20] = [
        ("--unit --node wide", &["'wide'", "--node", "expected wide4, quantised or wide8"]),
        ("--unit --node quantised --memory-width 1024", &["memory width is 1024", "expected 128, 256 or 512 with"]),
        ("--node quantised", &["--node quantised", "expected --unit"]),
        ("--unit --contexts 7", &["'7'", "--contexts", "expected 8 to 256"]),
        ("--unit --contexts many", &["'many'", "expected 8 to 256"]),
        ("--unit --stack 3", &["'3'", "--stack", "expected 2, 4, 8, 16 or 32"]),
        ("--unit --memory-width 64", &["'64'", "--memory-width", "expected 128, 256, 512 or 1024"]),
        ("--unit --id-width 65", &["'65'", "--id-width", "expected 1 to 64"]),
        ("--unit --address-width 31", &["'31'", "--address-width", "expected 32 to 64"]),
        ("--unit --divider-latency 0", &["'0'", "--divider-latency", "expected 1 to 27"]),
        ("--unit --rays 0", &["'0'", "--rays", "expected a whole number from 1"]),
        ("--contexts 8", &["--unit"]),
        ("--unit-features instances", &["--unit-features", "--unit"]),
        ("--unit --unit-features motion", &["'motion'", "--unit-features", "instances"]),
        ("--unit --with sphere", &["--unit", "cannot be used with", "--with"]),
        ("--unit --jobs 5", &["--unit", "cannot be used with", "--jobs"]),
        ("--unit --preset half", &["format fp16, expected format fp32", "expected format fp32"]),
        ("--unit --rules chisel", &["rules chisel", "expected rules paper"]),
        ("--unit --tag 4", &["tag 4", "expected tag 0"]),
        ("--unit --preset quantised", &["quantised-boxes true", "expected quantised-boxes false"]),
    ];
    for (options, words) in wrong {
        let arguments: Vec<&str> = ["generate"].into_iter().chain(options.split(' ')).collect();
        ends_with(&arguments, 2, words);
    }
    for command in ["generate", "wave", "ppa"] {
        let words = ["With --unit, --lanes has no effect", "--rules", "--conservative", "--exception-flags."];
        ends_with(&[command, "--help"], 0, &words);
    }
    ends_with(&["wave", "--unit", "jobs.txt"], 2, &["--unit", "cannot be used with", "FILES"]);
    ends_with(&["wave", "--contexts", "8", "jobs.txt"], 2, &["--contexts 8", "expected --unit"]);
}

/// The rays and hits of the waveform are those of the channels' handshakes, counted at the rising edges of the clock.
#[test]
fn wave_shows_the_channels_of_the_unit_and_the_names_of_its_parts() {
    const NS_PER_CYCLE: u64 = 10;
    let folder = folder();
    let path = folder.path().join("new/unit.fst");
    let out = text(&path);
    let options = "wave --unit --preset compact --contexts 8 --rays 12 --out";
    ends_with(&options.split(' ').chain([out.as_str()]).collect::<Vec<_>>(), 0, &["12 rays in "]);

    let mut waves = wellen::simple::read(&path).expect("a waveform");
    let cycles = waves.time_table().last().expect("a time") / NS_PER_CYCLE;
    let mut values = |scopes: &[&str], name: &str| {
        let variable = waves.hierarchy().lookup_var(scopes, name).unwrap_or_else(|| panic!("no {name} in {scopes:?}"));
        let signal = waves.hierarchy()[variable].signal_ref();
        waves.load_signals(&[signal]);
        let changes = waves.get_signal(signal).expect("loaded").iter_changes();
        let changes: Vec<(u64, String)> =
            changes.map(|(time, value)| (waves.time_table()[time as usize], value.to_string())).collect();
        let at = |time: u64| changes.iter().take_while(|(from, _)| *from <= time).last().expect("a value").1.clone();
        (0..cycles).map(|cycle| at(cycle * NS_PER_CYCLE)).collect::<Vec<String>>()
    };
    let top = ["raypath_unit"];
    let mut transfers = |valid: &str, ready: &str, id: &str| {
        let [valid, ready, id] = [valid, ready, id].map(|name| values(&top, name));
        let moves = valid.into_iter().zip(ready).map(|(valid, ready)| valid == "1" && ready == "1");
        id.into_iter().zip(moves).filter(|(_, moves)| *moves).map(|(id, _)| id).collect::<Vec<String>>()
    };
    let ids: Vec<String> = (0..12).map(|id| format!("{id:016b}")).collect();
    assert_eq!(transfers("ray_valid_i", "ray_ready_o", "ray_id_i"), ids);
    let mut hits = transfers("hit_valid_o", "hit_ready_i", "hit_id_o");
    hits.sort();
    assert_eq!(hits, ids);
    let fetched = transfers("mem_req_valid_o", "mem_req_ready_i", "mem_req_addr_o").len();
    let asked = values(&["raypath_unit", "u_walk"], "fetches_o").iter().filter(|value| *value == "1").count();
    assert_eq!((fetched, fetched > 12), (asked, true));
    values(&["raypath_unit", "u_datapath", "u_stage_5"], "quadbox_inside_0_tmin");
    values(&["raypath_unit", "u_walk", "u_stack"], "write_enable");
}

/// A unit with instances, and a scene of two levels for it.
#[test]
fn instances_on_the_command_line() {
    let folder = folder();
    let below = |name: &str| text(&folder.path().join(name));
    let (out, image) = (below("unit"), below("image.png"));
    let said = page::succeeds(&["generate", "--unit", "--unit-features", "instances", "--rays", "50", "--out", &out]);
    for words in ["instances; datapath", "hit_instance_o [31:0]", "| u_rays.u_object_constants ", "50 instances"] {
        assert!(said.contains(words), "no '{words}' in {said}");
    }
    let everything = ["--node", "wide8", "--unit-features", "instances,nested-instances", "--queries", "full"];
    let more = ["--edges", "once", "--rays", "100", "--out", &below("everything")];
    let said = page::succeeds(&[&["generate", "--unit"], &everything[..], &more[..]].concat());
    assert!(said.contains("50 instances") && said.contains("\n0 mismatches between netlist"), "{said}");
    let emitted = folder.path().join("everything");
    for top in ["raypath_unit_axi", "raypath_device"] {
        let list = std::fs::read_to_string(emitted.join(format!("{top}.f"))).expect("a list");
        let paths: Vec<PathBuf> = list.lines().map(|name| emitted.join(name)).collect();
        lint_verilator(&paths, top, &[]).expect("no report of Verilator");
        lint_slang(&paths).expect("no report of slang");
    }
    let list = std::fs::read_to_string(emitted.join("raypath_unit_wrapper.f")).expect("a list");
    let paths: Vec<PathBuf> = list.lines().map(|name| emitted.join(name)).collect();
    lint_verilator(&paths, "raypath_unit_wrapper", &[]).expect("no report of Verilator");
    lint_slang(&paths).expect("no report of slang");
    let all: String = paths.iter().map(|path| std::fs::read_to_string(path).expect("text")).collect();
    let all = file(&emitted, "all.sv", &all);
    lint_yosys(Path::new(&all), "raypath_unit_wrapper").expect("no report of Yosys");

    let places = "1 0 0 0 0 1 0 0 0 0 1 0\n-1 0 0 40 0 1 0 0 0 0 1 0\n";
    let places = file(folder.path(), "places.txt", places);
    let said = page::succeeds(&["scene", "--instances", &places, "--out", &below("scene.bin")]);
    assert!(said.contains("119168 triangles") && said.contains(", 2 instances: "), "{said}");
    let hits = below("hits.txt");
    let render = ["render", "--instances", &places, "--size", "48x33", "--out", &image];
    let said = page::succeeds(&[&render[..], &["--through", "unit", "--hits", &hits]].concat());
    assert!(said.contains("2 instances of 119168 triangles"), "{said}");
    let written = std::fs::read_to_string(&hits).expect("hits");
    assert!(["@0 ", "@1 "].iter().all(|instance| written.contains(instance)), "{written}");
    let drawn = below("drawn.png");
    page::succeeds(&["render", "--instances", &places, "--size", "48x33", "--draw", &hits, "--out", &drawn]);
    let bytes = |path: &str| std::fs::read(path).expect("a picture");
    assert!(bytes(&drawn) == bytes(&image), "the pictures differ");

    ends_with(&render, 2, &["--instances", "--through unit"]);
    let wrong = file(folder.path(), "wrong.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 2 3\n");
    ends_with(&["scene", "--instances", &wrong], 2, &["wrong.txt:2", "3 numbers, expected 12"]);
}

/// `examples/unit` on the commands of `docs/integration/unit.md`: the Verilated RTL behind cocotb's AXI4 memory traces
/// the rays of a picture of the built-in scene, with the hits of the functional model to the bit, and its picture is
/// the model's.
#[test]
#[ignore = "long: a build by Verilator; examples/queries has one, too"]
fn the_rtl_draws_the_picture_of_the_model() {
    const SIZE: &str = "8x6";
    let folder = folder();
    let below = |name: &str| text(&folder.path().join(name));
    page::succeeds(&["generate", "--unit", "--rays", "50", "--out", &below("")]);
    page::succeeds(&["scene", "--out", &below("scene.bin")]);
    let (rays, hits, model) = (below("rays.txt"), below("hits.txt"), below("model.png"));
    let render = ["render", "--through", "unit", "--size", SIZE, "--camera-rays", &rays, "--hits", &hits];
    page::succeeds(&[&render[..], &["--out", &model]].concat());

    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/unit/run.py");
    let output = Command::new("python3").arg(script).arg(folder.path()).output().expect("python3");
    let said = said(&output);
    assert!(!said.contains("No module named 'cocotb"), "install it with: pip install 'cocotb<2' 'cocotbext-axi<0.2'");
    assert!(output.status.success() && said.contains("TESTS=3 PASS=3 FAIL=0"), "{said}");

    let (traced, drawn) = (below("rtl-hits.txt"), below("rtl.png"));
    let said = page::succeeds(&["render", "--draw", &traced, "--size", SIZE, "--out", &drawn]);
    assert!(said.contains("48 pixels, 12 with a hit"), "{said}");
    let bytes = |path: &str| std::fs::read(path).expect("a picture");
    assert!(bytes(&drawn) == bytes(&model), "the pictures differ");

    // One pixel less, or another triangle, is another picture.
    let lines = std::fs::read_to_string(&traced).expect("hits");
    let changed = lines.replacen("miss\n", "5 1 1 1 3f800000 3f800000 3f800000\n", 1);
    let changed = file(folder.path(), "changed.txt", changed);
    page::succeeds(&["render", "--draw", &changed, "--size", SIZE, "--out", &drawn]);
    assert!(bytes(&drawn) != bytes(&model), "a changed hit shows");
}

/// `examples/agent`: the rays of a mesh, with stalls, reordered beats, errors of the memory and flushes. A bit of a hit
/// that changes is found. slang elaborates the covergroups, which Verilator 5.006 does not read.
#[test]
fn the_agent_compares_every_hit_with_the_model() {
    const SLANG: &str = "
import sys
from pyslang.driver import Driver
driver = Driver()
driver.addStandardArgs()
read = driver.parseCommandLine(' '.join(sys.argv)) and driver.processOptions() and driver.parseAllSources()
sys.exit(not (read and driver.runFullCompilation(True)))";
    let folder = folder();
    let below = |name: &str| text(&folder.path().join(name));
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/agent");
    let test = std::env::current_exe().expect("the path of this test");
    let mut bench = Command::new(examples.join("run.sh"));
    bench.arg(folder.path()).arg("+flush=50").env("RAYPATH", env!("CARGO_BIN_EXE_raypath")).env("SIZE", "16x12");
    // Cargo leaves libraypath beside the tests.
    let output = bench.env("RAYPATH_BUILT", test.parent().expect("a folder")).output().expect("bash");
    let whole = said(&output);
    assert!(output.status.success(), "{whole}");
    let counts = printed(&whole, "scoreboard: 192 rays, ");
    assert!(counts.ends_with(" 0 mismatches") && whole.contains(" of 48 bins"), "{whole}");

    let mut again = Command::new(below("bench/Vbench"));
    again.args([&format!("+folder={}", below("")), "+node_limit=40", "+corrupt_ray=17", "+corrupt_word=10"]);
    let output = again.output().expect("the bench");
    let corrupt = said(&output);
    assert!(!output.status.success(), "{corrupt}");
    assert!(printed(&corrupt, "ERROR: ray 17 (id 11): hit_triangles_o is ").contains(", expected "), "{corrupt}");

    let of = |name: &str| text(&examples.join(format!("raypath_{name}.sv")));
    let mut slang = Command::new("python3");
    slang.args(["-c", SLANG, "-Werror", "-DRAYPATH_COVERGROUPS", "--top", "bench", "-I", &below("bench")]);
    slang.args([&below("raypath_unit.sv"), &of("agent_pkg"), &of("unit_if"), &of("agent")]);
    slang.args(["driver", "memory", "scoreboard", "coverage"].map(|name| of(&format!("agent_{name}"))));
    let output = slang.arg(examples.join("bench.sv")).output().expect("python3");
    assert!(output.status.success(), "{}", said(&output));
}

#[test]
fn hits_that_are_not_of_the_picture_are_named() {
    let folder = folder();
    let out = text(&folder.path().join("image.png"));
    let hits = |name: &str, text: &str| file(folder.path(), name, text);
    let hit = "1 1 1 1 3f800000 3f800000 3f800000\n";
    let wrong = [
        (hits("few.txt", "miss\nmiss\nmiss\n"), ["3 hits", "expected 4"]),
        (hits("word.txt", "miss\nhit\n"), ["word.txt:2", "1 words, expected 7 or miss"]),
        (hits("bits.txt", "1 1 1 1 3f800000 3f8 3f800000\n"), ["bits '3f8'", "expected 8 hexadecimal digits"]),
        (hits("index.txt", &hit.replacen('1', "-1", 1)), ["triangle '-1'", "expected a whole number"]),
        (hits("instance.txt", &hit.replacen('1', "1@x", 1)), ["triangle '1@x'", "@ and an instance"]),
        (
            hits("large.txt", &format!("{}{hit}{hit}{hit}", hit.replacen('1', "119168b", 1))),
            ["pixel 0 shows triangle 119168", "expected one of the scene's 119168"],
        ),
    ];
    for (path, words) in &wrong {
        ends_with(&["render", "--draw", path, "--size", "2x2", "--out", &out], 2, words);
    }
    ends_with(&["render", "--draw", &wrong[0].0, "--shadows"], 2, &["--draw", "cannot be used with", "--shadows"]);
    assert!(!Path::new(&out).exists());
}
