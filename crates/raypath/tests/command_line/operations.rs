//! Added operations, and features of the paper's operations, on the command line.

use crate::command_line::{ends_with, file, folder, raypath, said, text};
use raypath::oracle::{AnyOperationSpec, added_operations};
use std::fs::read_to_string;

#[test]
fn operations_are_listed_with_their_cost() {
    let output = raypath(&["operations"]);
    assert!(output.status.success());
    let table = said(&output);
    let paper = ["triangle", "quadbox", "euclidean", "angular"];
    for name in added_operations().iter().map(AnyOperationSpec::name).chain(paper) {
        let row = table.lines().find(|line| line.starts_with(&format!("| {name} "))).expect(name);
        assert!(row.contains(" 12 ") && row.matches('|').count() == 7, "{row}");
    }
}

#[test]
fn an_operation_is_added_by_its_name() {
    let folder = folder();
    let out = text(&folder.path().join("with"));
    let names: Vec<&str> = added_operations().iter().map(AnyOperationSpec::name).collect();
    let [first, .., last] = names.as_slice() else { panic!("two operations") };
    let words = [
        format!("with {last}, {first}"),
        ": 0 mismatches".to_string(),
        format!("Oracle of {last}"),
        ": 0 of 600 random jobs have wrong results".to_string(),
    ];
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    ends_with(&["generate", "--with", &format!("{last},{first}"), "--jobs", "600", "--out", &out], 0, &words);
    let written = read_to_string(folder.path().join("with/raypath.sv")).expect("a file");
    assert!(written.contains(&format!("4 {last}, 5 {first}")), "opcodes in the head comment");
    assert!(folder.path().join("with/rtl/raypath_wrapper.sv").is_file());
    // The file of its jobs and outcomes can be replayed.
    let recorded = text(&folder.path().join(format!("with/{last}.txt")));
    ends_with(
        &["replay", "--with", last, "--engine", "both", &recorded],
        0,
        &["operation       jobs  mismatches", " 600           0\n"],
    );
    let half = ["generate", "--with", last, "--format", "fp16", "--jobs", "50", "--out", &out];
    ends_with(&half, 0, &[": 0 of 50 random jobs have wrong results"]);

    let words: Vec<&str> = std::iter::once("'spheer'").chain(names.iter().copied()).collect();
    ends_with(&["generate", "--with", "spheer", "--out", &out], 2, &words);
}

#[test]
fn features_are_options() {
    let folder = folder();
    let out = text(folder.path());
    let features = ["--tag", "8", "--barycentrics", "--culling", "none", "--facing", "--range", "--conservative"];
    let more = ["--accumulators", "4", "--exception-flags", "--jobs", "600", "--out", &out];
    ends_with(&[&["generate"], features.as_slice(), &more].concat(), 0, &[": 0 mismatches"]);
    let written = read_to_string(folder.path().join("raypath.sv")).expect("a file");
    for port in ["tag_o", "barycentric_u_o", "facing_o", "t_min_i", "accumulator_i", "exception_flags_o"] {
        assert!(written.contains(port), "{port}");
    }

    // The same features in a file.
    let features =
        file(folder.path(), "features.toml", "lanes = \"none\"\ntag = 8\nrange = true\nculling = \"none\"\n");
    ends_with(&["generate", "--config", &features, "--jobs", "100", "--out", &out], 0, &["tag 8", ": 0 mismatches"]);
}

#[test]
fn impossible_features_are_refused() {
    let folder = folder();
    let out = text(&folder.path().join("none"));
    for (arguments, words) in [
        (vec!["generate", "--tag", "33", "--out", &out], "expected a whole number from 0 to 32"),
        (vec!["generate", "--quantised-boxes", "--rules", "chisel", "--out", &out], "expected rules paper"),
        (vec!["generate", "--exception-flags", "--format", "fp16", "--out", &out], "expected format fp32"),
        (vec!["replay", "--exception-flags", "--format", "fp16", "triangle.txt"], "expected format fp32"),
        // The file name is not taken as the value of the option before it.
        (vec!["replay", "--facing", "triangle.txt"], "triangle.txt: No such file"),
        (vec!["replay", "--facing=maybe", "triangle.txt"], "'maybe'"),
        (vec!["render", "--tag", "8"], "features are for generate"),
        (vec!["generate", "--culling", "sides", "--out", &out], "sides"),
    ] {
        ends_with(&arguments, 2, &[words]);
        assert!(!folder.path().join("none").exists(), "{arguments:?} wrote something");
    }
}
