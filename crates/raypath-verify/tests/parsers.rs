//! All parsers on the corpora of `fuzz/` and mutations of them: no panic, no hang, bounded memory. The functions are
//! those of `fuzz` and of `raypath verify parsers`.

use raypath_verify::parsers::{TARGETS, corpus, run};
use raypath_verify::{Progress, Request};

#[test]
fn corpora_and_mutations_of_them() {
    let mut steps = 0;
    let mut watch = |step: Progress| {
        assert!(step.done <= step.total);
        steps += 1;
        true
    };
    let verdict = run(&mut Request { jobs: Some(100), seed: 3, ..Request::new(&mut watch) }).expect("a verdict");
    assert!(verdict.failures.is_empty() && !verdict.is_stopped, "{verdict:#?}");
    assert!(steps > 0);
}

/// Each corpus has a valid file; otherwise only the parsers' first checks would run.
#[test]
fn corpora_pass_the_first_checks() {
    for target in TARGETS {
        let files = corpus(target).expect("a corpus");
        let accepted = files.iter().filter(|bytes| (target.parse)(bytes)).count();
        assert!(accepted >= 1 && files.len() <= 200, "{}: {accepted} of {}", target.name, files.len());
        assert!(files.iter().all(|bytes| bytes.len() <= 16 << 10), "{}: files of a few kilobytes", target.name);
    }
}

/// Each folder of `fuzz/corpus`, which `fuzz/run.sh` runs, is a target's, and fuzz/README.md lists them.
#[test]
fn each_format_has_a_corpus_and_a_row() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz");
    let entries = std::fs::read_dir(folder.join("corpus")).expect("corpora");
    let mut found: Vec<_> = entries.map(|entry| entry.expect("a folder").file_name()).collect();
    let mut expected: Vec<std::ffi::OsString> =
        TARGETS.iter().map(|target| target.name.into()).chain(["c_interface".into()]).collect();
    found.sort();
    expected.sort();
    assert_eq!(found, expected);
    let readme = std::fs::read_to_string(folder.join("README.md")).expect("the list");
    let rows: Vec<&str> = readme.lines().filter(|line| line.starts_with("| `")).collect();
    let missing =
        |target: &&raypath_verify::parsers::Target| !rows.iter().any(|row| row.contains(&format!("`{}`", target.name)));
    assert!(TARGETS.iter().find(missing).is_none(), "{:?}", TARGETS.iter().find(missing));
}
