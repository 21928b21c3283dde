//! `raypath replay` reproduces the failures that a campaign has written to files.

use crate::command_line::{ends_with, file, folder, text};
use raypath::hdl::Module;
use raypath::hdl::mutate::{faults, replace};
use raypath::ops::Culling;
use raypath::oracle::added_operation;
use raypath::rtl::{Config, Control, DatapathNetlist, Lanes};
use raypath::sim::engine::shape;
use raypath_verify::{Request, Verdict};
use raypath_verify_datapath::campaign::verify_module;
use std::path::Path;
use std::sync::Arc;

/// The verdict on the netlist of a configuration, compared with the models of the default one.
fn verdict_on(netlist: Config, jobs: u64, seed: u64, folder: &Path) -> Verdict {
    let expected = DatapathNetlist::new(Config::DEFAULT).expect("a datapath");
    let tested = DatapathNetlist::new(netlist).expect("a datapath");
    let shape = shape(Config::DEFAULT, &expected);
    let proceed = &mut |_| true;
    let mut request = Request { jobs: Some(jobs), seed, ..Request::new(proceed) };
    verify_module(&mut request, tested.top(), &shape, folder).expect("a verdict")
}

/// The arguments of the command that replays a failure.
fn replay_of(failure: &str) -> Vec<&str> {
    failure.split_once("to replay it: raypath ").expect("a command").1.split(' ').collect()
}

fn transactions(arguments: &[&str]) -> usize {
    let files = arguments.iter().filter(|a| a.ends_with(".txt") && !a.ends_with("handshake.txt"));
    files.map(|file| std::fs::read_to_string(file).expect("a file").lines().count()).sum()
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
        assert!(command.contains(&"netlist") && transactions(&command) <= 3, "{failure}");
        assert!(!command.contains(&"--handshake"), "{failure}");
        ends_with(&[&command, &["--rules", "chisel"][..]].concat(), 1, &["differ from the recorded ones"]);
        ends_with(&command, 0, &[]);
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
    assert!(command.contains(&"both") && transactions(&command) <= 14, "{failure}");
    // The two controls differ only when the sink stalls.
    assert!(command.contains(&"--handshake"), "{failure}");
    // The netlist without the fault.
    ends_with(&command, 0, &[]);
    let wave = folder.path().join("trace.fst");
    let not_engine = command[1..].iter().filter(|argument| !["--engine", "both"].contains(argument));
    let mut arguments = vec!["wave"];
    arguments.extend(not_engine);
    ends_with(&[&arguments, &["--out", &text(&wave)][..]].concat(), 0, &[]);
    assert!(wave.exists());
}

#[test]
fn handshake_files_reproduce_withdrawals_and_resets() {
    let folder = folder();
    let beat =
        |seq: u32, sum: &str| format!("{seq:x} 0 0 1 {} {} {sum} 0\n", ["40000000"; 16].join(" "), ["0"; 16].join(" "));
    // The second job is withdrawn, and the first is lost in a reset: only the last leaves.
    let lines = [beat(0, "40800000"), beat(1, "0"), beat(2, "40800000")].concat();
    let jobs = file(folder.path(), "euclidean.txt", lines);
    let run = |pattern: &str, engine: &str, code: i32, words: &[&str]| {
        let handshake = file(folder.path(), "handshake.txt", pattern);
        ends_with(&["replay", &jobs, "--engine", engine, "--handshake", &handshake], code, words);
    };
    for engine in ["cycle", "netlist", "both"] {
        run("# a comment\nsk r\nw b", engine, 0, &["\nall                1           0\n"]);
        // Without the reset the sum continues.
        run("sk\nwb", engine, 1, &[]);
    }
    run("sk\nwx", "netlist", 2, &["handshake.txt:2: 'x' is not a valid cycle, expected b"]);
    run("sk\nw", "netlist", 2, &["handshake.txt: 'w' at the end, expected b"]);
    run("sk", "model", 2, &["--engine model has no cycles"]);
}

/// Failures of features and added operations shrink to files that replay as well.
#[test]
fn failures_of_features_and_added_operations_replay() {
    let config = Config::DEFAULT.lanes(Lanes::None).range(true).tag(5);
    let datapath = |config: Config| {
        let sphere = added_operation("sphere").expect("an operation");
        raypath::sim::Datapath::paper(config).with_any(sphere.operation()).elaborate().expect("a datapath")
    };
    let expected = datapath(config);
    let verdict_on = |top: &Arc<Module>, folder: &Path| {
        let proceed = &mut |_| true;
        let added = vec!["sphere".to_string()];
        let mut request = Request { config, added, jobs: Some(5120), ..Request::new(proceed) };
        let verdict = verify_module(&mut request, top, &shape(config, &expected), folder).expect("a verdict");
        let [failure] = verdict.failures.as_slice() else { panic!("{verdict:?}") };
        failure.clone()
    };

    let culled = folder();
    let failure = verdict_on(datapath(config.culling(Culling::Front)).top(), culled.path());
    let command = replay_of(&failure);
    assert!(command.iter().any(|part| part.ends_with("triangle.txt")) && transactions(&command) <= 3, "{failure}");
    ends_with(&[&command, &["--culling", "front"][..]].concat(), 1, &["differ from the recorded ones"]);
    ends_with(&command, 0, &[]);

    let faulty = folder();
    let modules = raypath::hdl::verilog::modules(expected.top()).expect("modules");
    let faulty_module = modules.iter().find_map(|module| {
        let fault = faults(module).into_iter().find(|fault| fault.to_string().contains("sphere_hit"))?;
        fault.apply(module).ok()
    });
    let wrong = replace(expected.top(), &Arc::new(faulty_module.expect("a fault"))).expect("a datapath");
    let failure = verdict_on(&wrong, faulty.path());
    let command = replay_of(&failure);
    assert!(command.iter().any(|part| part.ends_with("sphere.txt")) && transactions(&command) <= 3, "{failure}");
    ends_with(&command, 0, &[]);
}
