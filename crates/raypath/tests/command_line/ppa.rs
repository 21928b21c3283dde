//! `raypath ppa` and `raypath explore`: missing programs, wrong input, and stops.

use crate::command_line::{program_ends_with, said, text};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

/// The program in `folder`. It finds other programs only in `folder/bin`.
fn raypath(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_raypath"));
    command.args(arguments).current_dir(folder).env("PATH", folder.join("bin"));
    command
}

fn ends_with(folder: &Path, arguments: &[&str], code: i32, words: &[&str]) {
    program_ends_with(&mut raypath(folder, arguments), code, words);
    assert!(!folder.join("build").exists(), "{arguments:?} wrote something");
}

/// A library with the required cells.
const LIBRARY: &str = r#"library (small) {
  cell (BUFX2) { area : 1; pin (A) { direction : input; } pin (Y) { direction : output; function : "A"; } }
  cell (NAND2X1) { area : 1; pin (A) { direction : input; } pin (B) { direction : input; }
    pin (Y) { direction : output; function : "!(A B)"; } }
}
"#;

/// A folder with that library and a folder for programs.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("small.lib"), LIBRARY).expect("written");
    fs::create_dir(folder.path().join("bin")).expect("a folder");
    folder
}

fn program(folder: &Path, name: &str, script: &str) {
    use std::os::unix::fs::PermissionsExt;
    let path = folder.join("bin").join(name);
    fs::write(&path, format!("#!/bin/sh\n{script}\n")).expect("written");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("set");
}

#[test]
fn missing_tools_are_named_with_their_packages() {
    let folder = folder();
    let folder = folder.path();
    let ppa = ["ppa", "--liberty", "small.lib"];
    ends_with(
        folder,
        &ppa,
        2,
        &["yosys not found, expected Yosys 0.23 or newer; install it with: apt-get install yosys"],
    );
    ends_with(folder, &[&ppa[..], &["--yosys", "pyosys"]].concat(), 2, &["pyosys not found", "pip install pyosys"]);
    program(folder, "yosys", "echo 'Yosys 0.0 (none)'");
    ends_with(
        folder,
        &ppa,
        2,
        &["sta not found, expected OpenSTA 2.0 or newer; install it with: apt-get install opensta"],
    );
    ends_with(folder, &["explore", "--liberty", "small.lib"], 2, &["sta not found"]);
}

#[test]
fn wrong_input_is_named_before_any_work() {
    let folder = folder();
    let folder = folder.path();
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).expect("written");
    write("broken.lib", "library (x) {\n  area 3;\n}\n");
    write("bare.lib", "library (x) {\n}\n");
    write("lanes.toml", "control = ['skid', 'credit']\nlanes = [2, 3]\n");
    write("key.toml", "lane = [2]\n");
    write("empty.toml", "\nlanes = []\n");
    fs::create_dir(folder.join("earlier")).expect("a folder");
    write("earlier/ppa.json", "{\"design\": \"x\"}");
    write("one.fvecs", "\u{1}\0\0\0\0\0\0\0");
    let cases: [(&[&str], &[&str]); 22] = [
        (&["ppa", "--liberty", "none.lib"], &["none.lib: cannot read: No such file"]),
        (&["ppa", "--liberty", "broken.lib"], &["broken.lib:2: found '3', expected ':' or '('"]),
        (&["ppa", "--liberty", "bare.lib"], &["bare.lib: no NAND with two inputs in this library"]),
        (&["ppa", "--against", "nowhere"], &["nowhere/ppa.json: cannot read: No such file"]),
        (&["ppa", "--against", "earlier"], &["earlier/ppa.json: missing field `area`", "expected a report"]),
        (&["ppa", "--period", "0"], &["expected nanoseconds"]),
        (&["ppa", "--unit-period", "12"], &["--unit-period 12: expected less than --period, which is 12"]),
        (&["ppa", "--jobs", "0"], &["expected a whole number from 1 to 65535"]),
        (&["ppa", "--scene", "none.obj"], &["--power"]),
        (&["ppa", "--power", "--unit"], &["'--power' cannot be used with '--unit'"]),
        (&["ppa", "--power", "--scene", "none.obj"], &["none.obj: cannot read: No such file"]),
        (&["ppa", "--power", "--vectors", "one.fvecs"], &["one.fvecs: 1 vectors, expected at least 2"]),
        (&["ppa", "--power", "--recorded", "none.txt"], &["none.txt: "]),
        (&["explore", "--preset", "big"], &["'big' is not a valid preset, expected paper,"]),
        (&["explore", "--sweep", "lanes.toml"], &["lanes.toml:2: lanes: '3' is not a valid number of lanes"]),
        (&["explore", "--sweep", "key.toml"], &["key.toml:1: 'lane' is not a valid parameter"]),
        (&["explore", "--sweep", "empty.toml"], &["empty.toml:2: lanes: an empty list"]),
        (&["explore", "--goal", "area<=1"], &["'area<=1': '' is not its unit, expected 'area<=0.6mm2'"]),
        (&["explore", "--objective", "area,speed"], &["'speed' is not a metric, expected area, period, energy"]),
        (&["explore", "--goal", "area<=1mm2", "--first", "2"], &["expected a whole number from 6 to 10000"]),
        (&["explore", "--budget", "3"], &["--goal"]),
        (
            &["explore", "--goal", "area<=1mm2", "--objective", "area", "--liberty", "none.lib"],
            &["none.lib: cannot read"],
        ),
    ];
    for (arguments, words) in cases {
        ends_with(folder, arguments, 2, words);
    }
}

#[test]
fn a_failing_synthesiser_is_quoted() {
    let folder = folder();
    let folder = folder.path();
    program(folder, "yosys", "[ \"$1\" = -V ] && { echo 'Yosys 0.0 (none)'; exit; }\necho 'ERROR: no luck'; exit 1");
    program(folder, "sta", "echo 0.0");
    let words = ["Yosys 0.0 failed on raypath", "ERROR: no luck"];
    ends_with(folder, &["ppa", "--liberty", "small.lib", "--cache", "cache"], 2, &words);
    assert!(!folder.join("cache").exists());
}

/// A stop by Ctrl-C or `kill` ends the child programs, and no file is written.
#[test]
fn a_stop_ends_all_programs_and_writes_nothing() {
    for signal in ["INT", "TERM"] {
        let folder = folder();
        let folder = folder.path();
        let started = folder.join("started");
        // The child of the child must also end.
        let script = format!("/bin/sleep 600 & echo $! > {0}.new && /bin/mv {0}.new {0}; wait", text(&started));
        program(folder, "yosys", &format!("[ \"$1\" = -V ] && {{ echo 'Yosys 0.0 (none)'; exit; }}\n{script}"));
        program(folder, "sta", "echo 0.0");
        program(folder, "sh", "exec /bin/sh \"$@\"");
        let arguments = ["ppa", "--liberty", "small.lib", "--jobs", "1", "--cache", "cache"];
        let mut command = raypath(folder, &arguments);
        let running = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program");
        let wait = || std::thread::sleep(std::time::Duration::from_millis(20));
        while !started.exists() {
            wait();
        }
        let kill = Command::new("kill").args([format!("-{signal}"), running.id().to_string()]).status();
        assert!(kill.expect("kill").success());
        let output = running.wait_with_output().expect("an end");
        let said = said(&output);
        assert_eq!(output.status.code(), Some(130), "{said}");
        assert!(said.contains("stopped after 0 of") && said.contains("goes on from there"), "{said}");
        assert!(!folder.join("build").exists() && !folder.join("cache").exists());
        let sleeper = fs::read_to_string(&started).expect("a number");
        let status = || fs::read_to_string(format!("/proc/{}/stat", sleeper.trim()));
        while status().is_ok_and(|status| !status.contains(") Z ")) {
            wait();
        }
    }
}

/// In a format of eight bits, with the real tools: the front of a search is that of all configurations, which a first
/// set that is large enough contains. A budget ends the search, and the same command goes on from there.
#[test]
#[ignore = "two minutes of synthesis"]
fn a_search_finds_the_front_of_all_configurations() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let sweep = "lanes = 'none'\nformat = 'e4s4'\ncontrol = ['skid', 'credit']\ninterval = [1, 2, 4, 8]\n\
                 unit-latency = [1, 2]\nsharing = ['union', 'segregated']\n";
    fs::write(folder.join("sweep.toml"), sweep).expect("written");
    let explored = |more: &[&str]| -> serde_json::Value {
        let own = ["explore", "--sweep", "sweep.toml", "--objective", "area,period,throughput", "--json"];
        let mut command = Command::new(env!("CARGO_BIN_EXE_raypath"));
        let output = command.args(own).args(["--cache", "cache"]).args(more).current_dir(folder).output();
        let output = output.expect("the program");
        assert!(output.status.success(), "{}", said(&output));
        serde_json::from_slice(&output.stdout).expect("JSON")
    };
    let names = |found: &serde_json::Value, status: &str| -> Vec<String> {
        let points = found["points"].as_array().expect("points").iter();
        let chosen = points.filter(|point| point["status"] == status);
        chosen.map(|point| point["name"].as_str().expect("a name").to_string()).collect()
    };
    let begun = explored(&["--budget", "9"]);
    assert_eq!((&begun["measured"], &begun["is_finished"]), (&9.into(), &false.into()));
    let found = explored(&[]);
    let all = explored(&["--first", "1000"]);
    // An interval above 1 needs units of one step: of 32 combinations 12 are refused.
    let refused: u64 = all["refused"].as_object().expect("reasons").values().filter_map(|count| count.as_u64()).sum();
    assert_eq!((refused, &all["measured"], names(&all, "predicted").len()), (12, &20.into(), 0));
    assert!(!names(&all, "front").is_empty());
    assert_eq!(names(&found, "front"), names(&all, "front"));
    assert!(found["measured"].as_u64() < Some(20), "{} measured", found["measured"]);
    assert!(folder.join("build/explore/explore.html").exists());
}
