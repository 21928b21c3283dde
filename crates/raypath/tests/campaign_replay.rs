//! `raypath replay` reproduces the failures that a campaign has written to files.

use raypath::rtl::{Config, Control, Datapath};
use raypath::sim::engine::shape;
use raypath_verify::campaign::verify_module;
use raypath_verify::{Level, Request, Shard, Verdict};
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// The verdict on the netlist of a configuration, compared with the models of the default one.
fn verdict_on(netlist: Config, jobs: u64, seed: u64, folder: &Path) -> Verdict {
    let expected = Datapath::new(Config::DEFAULT).expect("a datapath");
    let tested = Datapath::new(netlist).expect("a datapath");
    let shape = shape(Config::DEFAULT, &expected);
    let (config, level, proceed) = (Config::DEFAULT, Level::Regression, &mut |_| true);
    let mut request = Request { config, level, jobs: Some(jobs), seed, shard: Shard::ALL, proceed };
    verify_module(&mut request, tested.top(), &shape, folder).expect("a verdict")
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

/// The files of a failure, and the arguments of the command that replays them.
fn replay_of(failure: &str) -> Vec<String> {
    let command = failure.split_once("to replay it: raypath ").expect("a command").1;
    command.split(' ').map(String::from).collect()
}

fn transactions(arguments: &[String]) -> usize {
    let files = arguments.iter().filter(|a| a.ends_with(".txt") && !a.ends_with("handshake.txt")).map(PathBuf::from);
    files.map(|file| std::fs::read_to_string(file).expect("a file").lines().count()).sum()
}

fn raypath(arguments: &[String], more: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_raypath")).args(arguments).args(more).output().expect("raypath runs");
    let text = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8_lossy(&text).into_owned())
}

/// Wrong outcomes: the failure of a netlist with other rules shrinks to at most three jobs. `replay` reports mismatches
/// on that netlist, and none on the right one.
#[test]
fn wrong_outcomes_shrink_to_files_that_replay() {
    let chisel = Config::DEFAULT.rules(raypath::ops::Rules::Chisel);
    for seed in 1..=3 {
        let folder = folder();
        let verdict = verdict_on(chisel, 5120, seed, folder.path());
        let [failure] = verdict.failures.as_slice() else { panic!("{:?}", verdict.failures) };
        let command = replay_of(failure);
        assert!(command.contains(&"netlist".to_string()) && transactions(&command) <= 3, "{failure}");
        assert!(!command.contains(&"--handshake".to_string()), "{failure}");
        let (code, text) = raypath(&command, &["--rules", "chisel"]);
        assert_eq!(code, Some(1), "{text}");
        assert!(text.contains("differ from the recorded ones"), "{text}");
        let (code, text) = raypath(&command, &[]);
        assert_eq!(code, Some(0), "{text}");
    }
}

/// Wrong timing: a netlist with another control has the right outcomes in the wrong cycles.
#[test]
fn wrong_times_shrink_to_files_and_handshakes_that_replay() {
    let credit = Config::DEFAULT.control(Control::Credit);
    let folder = folder();
    let verdict = verdict_on(credit, 5120, 1, folder.path());
    let [failure] = verdict.failures.as_slice() else { panic!("{:?}", verdict.failures) };
    let command = replay_of(failure);
    assert!(command.contains(&"both".to_string()) && transactions(&command) <= 14, "{failure}");
    // The two controls differ only when the sink stalls.
    assert!(command.contains(&"--handshake".to_string()), "{failure}");
    let (code, text) = raypath(&command, &[]);
    assert_eq!(code, Some(0), "the netlist as it should be: {text}");
    let wave = folder.path().join("trace.fst");
    let not_engine = command[1..].iter().filter(|argument| !["--engine", "both"].contains(&argument.as_str()));
    let arguments: Vec<String> = std::iter::once(&"wave".to_string()).chain(not_engine).cloned().collect();
    let (code, text) = raypath(&arguments, &["--out", &wave.display().to_string()]);
    assert_eq!(code, Some(0), "{text}");
    assert!(wave.exists());
}

#[test]
fn handshake_files_reproduce_withdrawals_and_resets() {
    let folder = folder();
    let (jobs, handshake) = (folder.path().join("euclidean.txt"), folder.path().join("handshake.txt"));
    let beat =
        |seq: u32, sum: &str| format!("{seq:x} 0 0 1 {} {} {sum} 0\n", ["40000000"; 16].join(" "), ["0"; 16].join(" "));
    // The second job is withdrawn, and the first is lost in a reset: only the last leaves.
    let lines = [beat(0, "40800000"), beat(1, "0"), beat(2, "40800000")].concat();
    std::fs::write(&jobs, lines).expect("written");
    let run = |pattern: &str, engine: &str| {
        std::fs::write(&handshake, pattern).expect("written");
        let arguments = ["replay", &jobs.display().to_string(), "--engine", engine, "--handshake"].map(String::from);
        raypath(&arguments, &[&handshake.display().to_string()])
    };
    for engine in ["cycle", "netlist", "both"] {
        let (code, text) = run("# a comment\nsk r\nw b", engine);
        assert_eq!(code, Some(0), "{engine}: {text}");
        assert!(text.lines().any(|line| line.split_whitespace().eq(["all", "1", "0"])), "{engine}: {text}");
        // Without the reset the sum continues.
        let (code, text) = run("sk\nwb", engine);
        assert_eq!(code, Some(1), "{engine}: {text}");
    }
    let (code, text) = run("sk\nwx", "netlist");
    assert_eq!(code, Some(2));
    assert!(text.contains("handshake.txt:2: 'x' is no cycle, expected b"), "{text}");
    let (code, text) = run("sk", "model");
    assert!(code == Some(2) && text.contains("--engine model has no cycles"), "{text}");
}
