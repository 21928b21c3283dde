//! Limits on sources and prose.

use crate::layout::{files, root, text};
use std::path::PathBuf;

/// The sources of all crates, without tests and examples.
fn sources() -> Vec<PathBuf> {
    let crates = std::fs::read_dir(root().join("crates")).expect("a folder");
    crates.flat_map(|entry| files(&entry.expect("a crate").path().join("src"), "rs")).collect()
}

/// All sources and documents of the repository.
fn prose() -> Vec<PathBuf> {
    let folders = ["crates", "examples", "docs"].map(|folder| root().join(folder));
    let mut found: Vec<PathBuf> =
        folders.iter().flat_map(|folder| [files(folder, "rs"), files(folder, "md")]).flatten().collect();
    found.extend(["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md"].map(|name| root().join(name)));
    found
}

fn lines_with(paths: &[PathBuf], is_wrong: impl Fn(&str) -> bool) -> Vec<String> {
    let mut found = Vec::new();
    for path in paths {
        for (number, line) in text(path).lines().enumerate().filter(|(_, line)| is_wrong(line)) {
            found.push(format!("{}:{}: {}", path.display(), number + 1, line.trim()));
        }
    }
    found
}

/// The facade only re-exports modules of other crates.
#[test]
fn the_facade_is_small() {
    let lines: usize =
        files(&root().join("crates/raypath/src"), "rs").iter().map(|path| text(path).lines().count()).sum();
    assert!(lines <= 3000, "crates/raypath/src has {lines} lines, expected at most 3000");
}

/// Parallel work goes through rayon. The threads of these files wait for a child process, a stream or a time limit.
#[test]
fn there_is_one_pool_of_workers() {
    let waiting = [
        "raypath-fpga/src/host.rs",
        "raypath-tools/src/verilator.rs",
        "raypath-tools/src/program.rs",
        "raypath-verify/src/mutation/trial.rs",
    ];
    let sources: Vec<PathBuf> =
        sources().into_iter().filter(|path| !waiting.iter().any(|waiting| path.ends_with(waiting))).collect();
    let found = lines_with(&sources, |line| line.contains("thread::spawn") || line.contains("thread::scope"));
    assert!(found.is_empty(), "threads beside rayon's:\n{}", found.join("\n"));
}

/// `Circuit` has arithmetic only. Faster implementations of particular operations are in a trait beside it.
#[test]
fn the_circuit_trait_has_arithmetic_only() {
    let text = text(&root().join("crates/raypath-ops/src/circuit.rs"));
    let begin = text.find("pub trait Circuit").expect("the trait");
    let end = begin + text[begin..].find("\n}\n").expect("its end");
    let methods: Vec<&str> =
        text[begin..end].lines().filter_map(|line| line.trim().strip_prefix("fn ")?.split(['(', '<']).next()).collect();
    let allowed = "stage stage_or auto label constant one_plus_ulps add sum subtract multiply negate narrow compare relation number_of test \
                   constant_bit and or not constant_word word_equal word_less select_num select_bit select_word zero infinity bit word";
    let others: Vec<&&str> =
        methods.iter().filter(|method| !allowed.split(' ').any(|allowed| allowed == **method)).collect();
    assert!(others.is_empty() && methods.len() > 20, "{others:?} of {methods:?}");
}

#[test]
fn prose_is_plain() {
    let words = ["nobody", "somebody", "whoever", "for who", "who wants", "who asks", "who reads"];
    // This file contains the words.
    let paths: Vec<PathBuf> = prose().into_iter().filter(|path| !path.ends_with("layout/sources.rs")).collect();
    let is_word = |line: &str, word: &str| {
        let line = line.to_lowercase();
        line.match_indices(word).any(|(at, _)| {
            let letter = |c: Option<char>| c.is_some_and(char::is_alphabetic);
            !letter(line[..at].chars().next_back()) && !letter(line[at + word.len()..].chars().next())
        })
    };
    let found = lines_with(&paths, |line| words.iter().any(|word| is_word(line, word)));
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// Comments fit the width. rustfmt ensures it for code, and cannot break text.
#[test]
fn lines_fit() {
    let rust: Vec<PathBuf> =
        prose().into_iter().filter(|path| path.extension().is_some_and(|end| end == "rs")).collect();
    let found = lines_with(&rust, |line| {
        line.chars().count() > 120 && line.trim().starts_with("//") && !line.contains("//! |")
    });
    assert!(found.is_empty(), "{}", found.join("\n"));
}
