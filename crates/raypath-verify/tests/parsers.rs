//! All parsers on the corpora of `fuzz/` and mutations of them: no panic, no hang, bounded memory. The functions are
//! those of `cargo fuzz` and of `raypath verify parsers`.

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
    let verdict = run(&mut Request { jobs: Some(500), seed: 3, ..Request::new(&mut watch) }).expect("a verdict");
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

/// Each target has a fuzz target and a corpus, and each fuzz target is a target.
#[test]
fn each_format_has_a_fuzz_target() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz");
    let manifest = std::fs::read_to_string(folder.join("Cargo.toml")).expect("a manifest");
    let mut sources = std::fs::read_dir(folder.join("fuzz_targets")).expect("sources").count();
    for target in TARGETS {
        assert!(manifest.contains(&format!("name = \"{}\"", target.name)), "{}", target.name);
        let source = std::fs::read_to_string(folder.join("fuzz_targets").join(format!("{}.rs", target.name)));
        assert!(source.expect("a source").contains(&format!("\"{}\"", target.name)), "{}", target.name);
        sources -= 1;
    }
    assert_eq!(sources, 0, "every fuzz target is used");
}
