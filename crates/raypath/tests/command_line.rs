//! The program as a user meets it: what it writes, what it says, how it ends.

use std::path::Path;
use std::process::{Command, Output};

const GOLDEN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/golden");

fn raypath(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_raypath")).args(arguments).output().expect("the program")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

fn ends_with(arguments: &[&str], code: i32, words: &[&str]) {
    let output = raypath(arguments);
    let said = said(&output);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
    for word in words {
        assert!(said.contains(word), "{arguments:?} should say '{word}': {said}");
    }
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

fn text(path: &Path) -> String {
    path.to_str().expect("a plain path").to_string()
}

/// All files below a folder, with their contents.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut open = vec![folder.to_path_buf()];
    let mut files = Vec::new();
    while let Some(next) = open.pop() {
        for entry in std::fs::read_dir(next).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = text(path.strip_prefix(folder).expect("below"));
                files.push((name, std::fs::read(&path).expect("a file")));
            }
        }
    }
    files.sort();
    files
}

#[test]
fn generate_writes_the_same_bytes_each_time() {
    let (first, second) = (folder(), folder());
    for folder in [&first, &second] {
        ends_with(&["generate", "--jobs", "200", "--out", &text(folder.path())], 0, &["latency 12", "0 mismatches"]);
    }
    // Once more over what is there already.
    ends_with(&["generate", "--jobs", "200", "--out", &text(second.path())], 0, &[]);
    let files = contents(first.path());
    assert_eq!(files, contents(second.path()));

    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    let of = |name: &str| String::from_utf8(files[names.iter().position(|n| *n == name).expect(name)].1.clone());
    let list = of("raypath.f").expect("text");
    let modules: Vec<&str> = list.lines().collect();
    assert_eq!(modules.len() + 3, files.len());
    assert_eq!(modules.last(), Some(&"rtl/raypath.sv"));
    let all = of("raypath.sv").expect("text");
    for module in modules {
        assert!(all.contains(&of(module).expect("text")), "{module} is not in raypath.sv");
    }
    assert!(all.contains("lanes 16, rules paper"));
}

#[test]
fn configurations_differ() {
    let mut texts = Vec::new();
    for (lanes, rules) in [("none", "paper"), ("none", "chisel"), ("16", "paper"), ("16", "chisel")] {
        let out = folder();
        let arguments = ["generate", "--lanes", lanes, "--rules", rules, "--jobs", "500", "--out", &text(out.path())];
        ends_with(&arguments, 0, &["0 mismatches", "latency 12 cycles, initiation interval 1"]);
        texts.push(std::fs::read_to_string(out.path().join("raypath.sv")).expect("text"));
    }
    texts.dedup();
    assert_eq!(texts.len(), 4);
    assert!(!texts[0].contains("euclidean") && texts[2].contains("euclidean"));
}

#[test]
fn replay_compares_with_the_record() {
    let files = ["triangle", "quadbox", "euclidean", "angular"].map(|kind| format!("{GOLDEN}/{kind}.txt.gz"));
    for engine in ["model", "cycle", "netlist"] {
        let mut arguments =
            vec!["replay", "--rules", "chisel", "--engine", engine, "--interleave", "--handshake", "random"];
        arguments.extend(files.iter().map(String::as_str));
        ends_with(&arguments, 0, &["24576"]);
    }
    // The rules differ, and a mismatch is shown field by field.
    ends_with(&["replay", &files[1]], 1, &["mismatch: quadbox job", "* box_index_", "outcomes differ"]);
}

#[test]
fn replay_reads_plain_files_of_any_name() {
    let folder = folder();
    let path = folder.path().join("jobs");
    let line = "0 0 1 ffff".to_string() + &" 40000000".repeat(16) + &" 3f800000".repeat(16);
    std::fs::write(&path, format!("# one beat of ones\n\n{line} 41800000 1\n")).expect("a file");
    ends_with(&["replay", "--kind", "euclidean", &text(&path)], 0, &["euclidean"]);
    std::fs::write(&path, format!("{line} 41800001 1\n")).expect("a file");
    ends_with(&["replay", "--kind", "euclidean", &text(&path)], 1, &["41800000 1.6e1", "41800001"]);
}

#[test]
fn wrong_input_is_named() {
    let folder = folder();
    let file = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("a file");
        text(&path)
    };
    let beat = "0 0 1 ff".to_string() + &" 40000000".repeat(16) + " 0 0 1";
    let wrong_digit = file("angular_digit.txt", beat.replacen("40000000", "4000000g", 1).as_bytes());
    let too_wide = file("angular_wide.txt", format!("\n{}", beat.replace(" ff ", " 1ff ")).as_bytes());
    let signed = file("angular_signed.txt", beat.replace(" ff ", " +f ").as_bytes());
    let short = file("angular_short.txt", b"0 0 1 ff");
    let broken = file("angular_broken.txt.gz", &[0x1f, 0x8b, 8, 0, 1, 2, 3]);
    let not_text = file("angular_not_text.txt", &[b'0', 0xff, 0xfe]);
    let empty = file("angular_empty.txt", b"");
    let nameless = file("jobs.txt", beat.as_bytes());
    let cases: [(&[&str], &[&str]); 16] = [
        (&["replay", "/nonexistent/triangle.txt"], &["/nonexistent/triangle.txt", "No such file"]),
        (&["replay", &wrong_digit], &["angular_digit.txt:1", "field 5", "euclidean_a_0", "4000000g", "hexadecimal"]),
        (&["replay", &too_wide], &["angular_wide.txt:2", "field 4", "euclidean_mask", "1ff", "at most ff"]),
        (&["replay", &signed], &["angular_signed.txt:1", "+f"]),
        (&["replay", &short], &["angular_short.txt:1", "4 fields", "expected 23"]),
        (&["replay", &broken], &["angular_broken.txt.gz"]),
        (&["replay", &not_text], &["angular_not_text.txt"]),
        (&["replay", &empty], &["no transactions"]),
        (&["replay", &nameless], &["jobs.txt", "--kind"]),
        (&["replay"], &["FILES"]),
        (&["generate", "--lanes", "0"], &["'0' lanes", "none or 16"]),
        (&["generate", "--rules", "none"], &["'none' is no rule set", "paper or chisel"]),
        (&["generate", "--out", &nameless], &["jobs.txt"]),
        (&["generate", "--jobs", "0"], &["'0'", "1..="]),
        (&["ray", "--origin", "1", "2", "3", "--direction", "0", "-0", "0"], &["direction (0, -0, 0) is zero"]),
        (&["ray", "--origin", "1", "2", "3", "--direction", "0", "1", "0", "--extent", "-1"], &["extent -1"]),
    ];
    for (arguments, words) in cases {
        ends_with(arguments, 2, words);
    }
}

#[test]
fn ray_derives_what_the_ports_want() {
    let words = ["ray_inv_y_i      ff800000  -inf", "ray_shear_x_i    bf000000  -5e-1", "ray_kz_i         2"];
    ends_with(&["ray", "--origin", "0", "0", "-5", "--direction", "-0.5", "-0", "1"], 0, &words);
}

#[test]
fn nothing_half_written_stays() {
    let folder = folder();
    let out = folder.path().join("out");
    // A folder stands where a file should be: every file before it must stay away as well.
    std::fs::create_dir_all(out.join("raypath.sv/occupied")).expect("a folder");
    ends_with(&["generate", "--out", &text(&out)], 2, &["raypath.sv"]);
    let left = contents(&out);
    assert!(left.is_empty(), "{:?}", left.iter().map(|(name, _)| name).collect::<Vec<_>>());

    let wave = folder.path().join("no/such/folder/trace.fst");
    let golden = format!("{GOLDEN}/quadbox.txt.gz");
    ends_with(&["wave", &golden, "--jobs", "10", "--out", &text(&wave)], 2, &["trace.fst"]);
    assert!(!wave.exists());
}

#[test]
fn wave_shows_ports_handshakes_and_the_algorithms_names() {
    let folder = folder();
    let path = folder.path().join("trace.fst");
    let golden = format!("{GOLDEN}/quadbox.txt.gz");
    let arguments = ["wave", "--rules", "chisel", &golden, "--jobs", "50", "--out", &text(&path)];
    ends_with(&arguments, 0, &["50 jobs in 62 cycles"]);

    let mut waves = wellen::simple::read(&path).expect("a waveform");
    let signal_of = |waves: &wellen::simple::Waveform, scopes: &[&str], name: &str| {
        let variable = waves.hierarchy().lookup_var(scopes, name).unwrap_or_else(|| panic!("no {name} in {scopes:?}"));
        waves.hierarchy()[variable].signal_ref()
    };
    signal_of(&waves, &["raypath"], "input_ready_o");
    signal_of(&waves, &["raypath", "u_stage_4"], "ready_o");
    signal_of(&waves, &["raypath", "u_stage_5"], "quadbox_inside_0_tmin");
    let valid = signal_of(&waves, &["raypath"], "output_valid_o");
    waves.load_signals(&[valid]);
    let signal = waves.get_signal(valid).expect("loaded");
    // Jobs enter from cycle 0 on; the first is valid twelve cycles later, the last leaves at the end of cycle 61.
    let changes: Vec<(u64, String)> =
        signal.iter_changes().map(|(time, value)| (waves.time_table()[time as usize], value.to_string())).collect();
    assert_eq!(changes.first().map(|(_, value)| value.as_str()), Some("0"));
    assert_eq!(changes.get(1), Some(&(120, "1".to_string())), "{changes:?}");
    assert_eq!(changes.len(), 2, "{changes:?}");
}
