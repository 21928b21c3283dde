//! The documents: chapters, includes, links, paths of files, and the quoted output of examples.

use crate::layout::{files, root, text};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A chapter's file and text.
struct Chapter {
    file: PathBuf,
    text: String,
}

impl Chapter {
    /// A path that the chapter names.
    fn resolve(&self, path: &str) -> PathBuf {
        self.file.parent().expect("a folder").join(path)
    }
}

fn book() -> PathBuf {
    root().join("docs")
}

fn chapter(file: PathBuf) -> Chapter {
    Chapter { text: text(&file), file }
}

/// The chapters that the summary lists.
fn chapters() -> Vec<Chapter> {
    let summary = chapter(book().join("SUMMARY.md"));
    links(&summary.text).into_iter().map(|link| chapter(summary.resolve(&link))).collect()
}

/// The targets of links outside of code.
fn links(text: &str) -> Vec<String> {
    let prose = text.split("```").step_by(2).collect::<String>();
    let prose = prose.split('`').step_by(2).collect::<String>();
    let targets = prose.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    targets.map(|(target, _)| target.to_string()).collect()
}

/// The path and the anchor of each `{{#include ...}}`.
fn includes(text: &str) -> Vec<(String, Option<String>)> {
    let found = text.split("{{#include ").skip(1).filter_map(|rest| rest.split_once("}}"));
    found
        .map(|(target, _)| match target.trim().split_once(':') {
            Some((path, anchor)) => (path.to_string(), Some(anchor.to_string())),
            None => (target.trim().to_string(), None),
        })
        .collect()
}

#[test]
fn every_chapter_is_listed_and_exists() {
    let listed: BTreeSet<_> = chapters().into_iter().map(|chapter| chapter.file).collect();
    let mut there: BTreeSet<_> = files(&book(), "md").into_iter().collect();
    there.remove(&book().join("SUMMARY.md"));
    assert_eq!(listed, there);
}

/// Source files name documents by their path from the repository's root.
#[test]
fn every_document_that_sources_name_exists() {
    let mut seen = 0;
    for file in files(&root().join("crates"), "rs") {
        for rest in text(&file).split("`docs/").skip(1) {
            let path = rest.split(['`', '#', '"']).next().unwrap_or_default();
            let is_foreign = path == "kanata-log-format.md"; // of the project Konata
            assert!(is_foreign || book().join(path).exists(), "{}: docs/{path}", file.display());
            seen += 1;
        }
    }
    assert!(seen > 20, "{seen} documents named");
}

/// Documents name files by their path from the repository's root or from `crates`, for example
/// `crates/raypath-ops/src/rules.rs` and `raypath-ops/src/rules.rs`.
#[test]
fn every_path_that_documents_name_exists() {
    let outside = ["README.md", "CONTRIBUTING.md", "SECURITY.md", "fuzz/README.md"].map(|name| root().join(name));
    let mut seen = 0;
    for document in files(&book(), "md").into_iter().chain(outside) {
        let prose = text(&document).split("```").step_by(2).collect::<String>();
        for path in prose.split('`').skip(1).step_by(2) {
            // The plan names tests in files: `raypath-hdl/tests/lanes.rs::...`.
            let (path, _) = path.split_once("::").unwrap_or((path, ""));
            let folder = match path.split_once('/') {
                Some((first, _)) if first.starts_with("raypath-") => root().join("crates"),
                Some(("crates" | "examples" | "docs" | ".github", _)) => root().to_path_buf(),
                _ => continue,
            };
            assert!(folder.join(path).exists(), "{}: {path}", document.display());
            seen += 1;
        }
    }
    assert!(seen > 150, "{seen} paths");
}

/// Links of the documents outside of the book lead to files.
#[test]
fn every_link_outside_of_the_book_resolves() {
    let examples = ["examples/cocotb/README.md", "examples/unit/README.md"];
    for name in
        ["README.md", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md", "fuzz/README.md"].into_iter().chain(examples)
    {
        let document = chapter(root().join(name));
        for link in links(&document.text).into_iter().filter(|link| !link.starts_with("http")) {
            let (path, _) = link.split_once('#').unwrap_or((&link, ""));
            assert!(document.resolve(path).exists(), "{name}: {link}");
        }
    }
}

/// Each included anchor begins and ends once in its file, and has contents.
#[test]
fn every_include_resolves() {
    let mut seen = 0;
    for chapter in chapters() {
        for (path, anchor) in includes(&chapter.text) {
            let place = format!("{}: {path}:{anchor:?}", chapter.file.display());
            let included = text(&chapter.resolve(&path));
            let anchor = anchor.unwrap_or_else(|| panic!("{place}: no anchor"));
            assert!(anchored(&included, &anchor).is_some_and(|lines| !lines.is_empty()), "{place}: no such anchor");
            seen += 1;
        }
    }
    assert!(seen >= 7, "{seen} includes");
}

/// The lines between a pair of anchors.
fn anchored<'t>(text: &'t str, anchor: &str) -> Option<Vec<&'t str>> {
    let at = |mark: String| {
        let mut found = text.lines().enumerate().filter(|(_, line)| line.trim_start().ends_with(&mark));
        let first = found.next();
        first.filter(|_| found.next().is_none()).map(|(number, _)| number)
    };
    let (begin, end) = (at(format!(" ANCHOR: {anchor}"))?, at(format!(" ANCHOR_END: {anchor}"))?);
    let between = text.lines().take(end).skip(begin + 1);
    Some(between.filter(|line| !line.trim().is_empty()).collect())
}

#[test]
fn anchors_are_distinguished() {
    let text = "// ANCHOR: a\none\n// ANCHOR_END: a\n# ANCHOR: b\n# ANCHOR_END: b\n// ANCHOR: c\n";
    assert_eq!(anchored(text, "a"), Some(vec!["one"]));
    assert_eq!(anchored(text, "b"), Some(vec![]));
    assert_eq!(anchored(text, "c"), None);
}

/// Links lead to files of the book, so that they also work in its pages, or to other sites.
#[test]
fn every_link_resolves() {
    let folder = book().canonicalize().expect("the book");
    let mut seen = 0;
    for chapter in chapters() {
        for link in links(&chapter.text).into_iter().filter(|link| !link.starts_with("http")) {
            let (path, _) = link.split_once('#').unwrap_or((&link, ""));
            let target = chapter.resolve(path).canonicalize().ok();
            let is_inside = target.is_some_and(|target| target.starts_with(&folder));
            assert!(is_inside || path.is_empty(), "{}: {link}", chapter.file.display());
            seen += 1;
        }
    }
    assert!(seen > 60, "{seen} links");
}

/// The output that a chapter quotes after an include of an example is the complete output of that example.
#[test]
fn quoted_output_is_that_of_the_examples() {
    let mut seen = 0;
    for chapter in chapters() {
        let mut rest = chapter.text.as_str();
        while let Some((before, after)) = rest.split_once("```text\n") {
            let (quoted, next) = after.split_once("```").expect("an end of the quotation");
            let Some((path, _)) = includes(before).pop() else {
                rest = next;
                continue;
            };
            let example = Path::new(&path).file_stem().and_then(|stem| stem.to_str()).expect("an example").to_string();
            assert_eq!(printed(&example), quoted, "{}: {example}", chapter.file.display());
            (rest, seen) = (next, seen + 1);
        }
    }
    assert_eq!(seen, 3);
}

/// The output of an example of `raypath-model`.
fn printed(example: &str) -> String {
    let mut cargo = Command::new(env!("CARGO"));
    let fixed = "run --quiet --profile tests --locked --package raypath-model --example";
    cargo.args(fixed.split(' ')).arg(example);
    let output = cargo.current_dir(env!("CARGO_MANIFEST_DIR")).output().expect("cargo");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}
