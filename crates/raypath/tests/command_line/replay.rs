//! `raypath replay` of added operations, and its reports.

use crate::command_line::{GOLDEN, ends_with, file, folder, page, printed, text};
use raypath::model::Model;
use raypath::oracle::added_operations;
use raypath::rtl::Config;
use raypath::sim::transactions::{Transaction, read, text as as_text};
use raypath::sim::{Datapath, WordModel};

#[test]
fn recorded_jobs_in_a_report() {
    let folder = folder();
    let (report, log) = (folder.path().join("report.html"), folder.path().join("log.txt"));
    let files = ["triangle", "quadbox", "euclidean", "angular"].map(|kind| format!("{GOLDEN}/{kind}.txt.gz"));
    for engine in ["cycle", "netlist"] {
        let mut arguments = vec!["replay", "--rules", "chisel", "--engine", engine, "--interleave", "--handshake"];
        arguments.extend(["random", "--window-jobs", "500"]);
        arguments.extend(files.iter().map(String::as_str));
        let said = page::writes(&arguments, folder.path(), &[("--report", "report.html"), ("--konata", "log.txt")]);
        page::agrees(&report, &said);
        // All 24,576 jobs have the recorded outcomes.
        let counts = page::counts(&report);
        assert!(counts.contains(&("jobs".to_string(), "24576".to_string())), "{counts:?}");
        assert!(counts.contains(&("mismatches".to_string(), "0".to_string())), "{counts:?}");
        // In the log each job of the window begins and retires.
        let log = std::fs::read_to_string(&log).expect("a log");
        let lines = |kind: &str| log.lines().filter(|line| line.starts_with(kind)).count();
        assert_eq!((lines("I\t"), lines("R\t")), (500, 500));
    }
    // The functional model has no cycles.
    ends_with(&["replay", "--rules", "chisel", &files[0], "--report", "r.html"], 2, &["--engine model has no cycles"]);
}

/// The model of the paper's datapath with an added operation, and `count` jobs of the operation with their outcomes.
fn added(name: &str, seed: u64, count: usize) -> (WordModel, Vec<Transaction>) {
    let specs = added_operations();
    let spec = specs.iter().find(|spec| spec.name() == name).expect("an operation");
    let datapath = Datapath::paper(Config::DEFAULT).with_any(spec.operation());
    let mut model = datapath.model();
    let kind = model.kind(name).expect("an operation");
    let jobs = raypath::oracle::jobs(&datapath, &specs, seed, &[kind]).take(count).enumerate();
    let stream = jobs.map(|(seq, job)| Transaction { seq: seq as u64, category: 1, expected: model.run(&job), job });
    let stream = stream.collect();
    model.reset();
    (model, stream)
}

/// The transactions of each operation that can be added are equal after they were written and read.
#[test]
fn transactions_of_any_operation_survive_a_file() {
    let (folder, all) = (folder(), added_operations());
    assert!(!all.is_empty(), "no operation is registered");
    for spec in &all {
        let (model, stream) = added(spec.name(), 7, 300);
        let kind = model.kind(spec.name()).expect("an operation");
        let written = as_text(&model, kind, &stream, Config::DEFAULT);
        let path = file(folder.path(), &format!("{kind}.txt"), &written);
        let again = read(path.as_ref(), None, &model, Config::DEFAULT).expect("transactions");
        assert_eq!(again, stream, "{kind}");
        let fields = 2 + model.inputs(kind).len() + model.outputs(kind).len();
        assert!(written.lines().all(|line| line.split(' ').count() == fields), "{kind}");
        let with = ["replay", "--with", spec.name(), &path, "--handshake", "random", "--engine", "both"];
        ends_with(&with, 0, &[spec.name(), "300           0"]);
    }
}

#[test]
fn an_added_operation_is_replayed_and_shown() {
    let folder = folder();
    // Any registered operation.
    let name = added_operations().first().expect("an operation").name();
    let (model, stream) = added(name, 3, 2000);
    let kind = model.kind(name).expect("an operation");
    let last = model.outputs(kind).last().expect("an output").name.clone();
    let written = as_text(&model, kind, &stream, Config::DEFAULT);
    let jobs = file(folder.path(), &format!("{name}.txt"), &written);
    let (boxes, report) = (format!("{GOLDEN}/quadbox.txt.gz"), text(&folder.path().join("report.html")));
    for engine in ["model", "cycle", "netlist"] {
        let common = ["replay", "--rules", "chisel", "--with", name, "--engine", engine, "--interleave", "--handshake"];
        let shown = ["random", "--report", &report, &jobs, &boxes];
        let arguments = match engine {
            "model" => [&common[..], &["random", &jobs, &boxes]].concat(),
            _ => [&common[..], &shown].concat(),
        };
        let said = page::succeeds(&arguments);
        assert_eq!(printed(&said, name).split_whitespace().collect::<Vec<_>>(), ["2000", "0"], "{said}");
    }
    // The page shows the operation in the legend, in the choice of utilisation and as a row.
    let page = std::fs::read_to_string(&report).expect("a page");
    assert_eq!(page.matches(&format!("<i class=\"key op4\"></i>{name}")).count(), 3);
    assert!(page.contains(&format!("\"operations\":[\"triangle\",\"quadbox\",\"euclidean\",\"angular\",\"{name}\"]")));
    page::counts(report.as_ref());

    // A changed digit of an outcome is found, and its field is named.
    let mut lines: Vec<String> = written.lines().map(str::to_string).collect();
    let digit = lines[1000].len() - 1;
    let other = if lines[1000].ends_with('0') { "1" } else { "0" };
    lines[1000].replace_range(digit.., other);
    let wrong = file(folder.path(), &format!("{name}_wrong.txt"), lines.join("\n"));
    for engine in ["model", "netlist"] {
        let mismatch = format!("mismatch: {name} job, seq 0003e8, cat 1");
        let words = [&mismatch, &format!("* {last}"), "1 of 2000 outcomes differ"];
        ends_with(&["replay", "--with", name, "--engine", engine, &wrong], 1, &words);
    }

    let wave = text(&folder.path().join("trace.fst"));
    ends_with(&["wave", "--with", name, "--jobs", "50", "--out", &wave, &jobs], 0, &["50 jobs in 62 cycles"]);

    let other = file(folder.path(), "jobs.txt", &written);
    ends_with(&["replay", "--with", name, "--kind", name, &other], 0, &["2000"]);
    let (all, without) = ("expected triangle, quadbox, euclidean or angular", format!("(without --with {name})"));
    ends_with(&["replay", &jobs], 2, &[&format!("{name}.txt: {name} jobs"), &without, all]);
    ends_with(
        &["replay", "--kind", name, &other],
        2,
        &[&format!("'{name}' is not a valid kind of job {without}"), all],
    );
    let all = &format!("expected triangle, quadbox, euclidean, angular or {name}");
    ends_with(&["replay", "--with", name, &other], 2, &["jobs.txt: the name begins with no kind of job", all]);
    let lanes = ["replay", "--with", name, "--lanes", "none", "--kind", "angular", &other];
    ends_with(
        &lanes,
        2,
        &[&format!("'angular' is not a valid kind of job (no distance modes), expected triangle, quadbox or {name}")],
    );
}
