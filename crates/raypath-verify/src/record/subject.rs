//! What a result depends on: the files of an item's subject, and their digest.

use crate::Error;
use crate::files::in_folder;
use raypath_tools::{digest, read};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The crate whose modules are followed.
const VERIFY: &str = "crates/raypath-verify/src";
/// Modules of [`VERIFY`] that carry requests and results. No result depends on them.
const CARRIERS: [&str; 4] = ["error", "files", "items", "request"];

/// Modules that change no result of a program that does not name them, because they define no methods of types of other
/// modules: path, and the words by which others name them.
const SEPARATE: [(&str, &[&str]); 7] = [
    ("crates/raypath-hdl/src/lanes", &["LANES", "LaneSimulator"]),
    ("crates/raypath-hdl/src/mutate", &["mutate"]),
    ("crates/raypath-rtl/src/package", &["package"]),
    ("crates/raypath-sim/src/configuration", &["configuration"]),
    ("crates/raypath-sim/src/files", &["files"]),
    ("crates/raypath-sim/src/frames", &["frames"]),
    ("crates/raypath-sim/src/transactions", &["transactions"]),
];

/// The SHA-256, in hexadecimal digits, of the files of a subject in the repository at `root`. Tests, lines with only a
/// comment, empty lines and indentation have no effect.
pub(super) fn hash(root: &Path, subject: &[&str]) -> Result<String, Error> {
    let mut bytes = Vec::new();
    for (path, text) in files(root, subject)? {
        bytes.extend(path.bytes());
        for line in text.lines() {
            bytes.push(b'\n');
            bytes.extend(line.bytes());
        }
        bytes.push(0);
    }
    Ok(digest(&bytes))
}

/// The files of a subject, by path from `root`, with the text that counts: those under its paths, with the modules of
/// this crate that they import, and without the separate modules that none of them names.
pub(super) fn files(root: &Path, subject: &[&str]) -> Result<BTreeMap<String, String>, Error> {
    let mut files = BTreeMap::new();
    let mut pending: Vec<String> = subject.iter().map(|path| path.to_string()).collect();
    let mut done = BTreeSet::new();
    while let Some(path) = pending.pop() {
        if !done.insert(path.clone()) {
            continue;
        }
        let mut found = BTreeMap::new();
        collect(root, &root.join(&path), &mut found)?;
        if path.starts_with(VERIFY) {
            // A module's own file, and those that it imports.
            let names = found.values().flat_map(|text| imported(text)).map(|name| format!("{VERIFY}/{name}"));
            let modules = names.chain([path.trim_end_matches(".rs").to_string()]);
            let both = modules.flat_map(|module| [format!("{module}.rs"), module]);
            pending.extend(both.filter(|path| root.join(path).exists()));
        }
        files.extend(found);
    }
    for (module, words) in SEPARATE {
        let is_inside = |path: &str| path.strip_prefix(module).is_some_and(|rest| rest.starts_with(['/', '.']));
        let declares = Path::new(module).with_file_name("lib.rs");
        let names = |(path, text): (&String, &String)| {
            !is_inside(path) && Path::new(path) != declares && words.iter().any(|word| has_path(text, word))
        };
        if !files.iter().any(names) {
            files.retain(|path, _| !is_inside(path));
        }
    }
    Ok(files)
}

/// The modules that a text of [`VERIFY`] imports, without those that carry results.
fn imported(text: &str) -> BTreeSet<String> {
    let lists = text.split("crate::").skip(1).map(|rest| match rest.strip_prefix('{') {
        Some(list) => list.split('}').next().unwrap_or_default(),
        None => rest.split(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap_or_default(),
    });
    let names = lists.flat_map(|list| list.split(',')).filter_map(|name| name.trim().split("::").next());
    let is_module = |name: &&str| name.starts_with(char::is_lowercase) && !CARRIERS.contains(name);
    names.filter(is_module).map(str::to_string).collect()
}

/// Whether a text has a word as a part of a path or of a list of names.
fn has_path(text: &str, word: &str) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(word).any(|(at, _)| {
        let (before, after) = (&text[..at], &text[at + word.len()..]);
        let is_whole = !before.ends_with(is_part) && !after.starts_with(is_part);
        is_whole && (before.ends_with("::") || before.trim_end().ends_with(['{', ',']) || after.starts_with("::"))
    })
}

/// Adds a file, or all files in a folder and below, without tests.
fn collect(root: &Path, path: &Path, files: &mut BTreeMap<String, String>) -> Result<(), Error> {
    let is_test = |path: &PathBuf| path.file_stem().is_some_and(|name| name == "tests");
    if path.is_file() {
        let text = String::from_utf8_lossy(&read(path)?).into_owned();
        let name = path.strip_prefix(root).unwrap_or(path).to_string_lossy().into_owned();
        files.insert(name, code(&text));
        return Ok(());
    }
    in_folder(path)?.into_iter().filter(|path| !is_test(path)).try_for_each(|entry| collect(root, &entry, files))
}

/// A text without comments, empty lines, indentation, and the tests at its end.
fn code(text: &str) -> String {
    let lines: Vec<&str> =
        text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//")).collect();
    let is_tests = |pair: &[&str]| pair[0] == "#[cfg(test)]" && pair[1].starts_with("mod tests");
    let end = lines.windows(2).position(is_tests).unwrap_or(lines.len());
    lines[..end].join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder with files of these paths and texts.
    fn repository(files: &[(&str, &str)]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a folder");
        for (path, text) in files {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("folders");
            std::fs::write(path, text).expect("a file");
        }
        folder
    }

    #[test]
    fn the_hash_depends_on_code_and_not_on_comments_or_tests() {
        let hash_of = |text: &str| hash(repository(&[("a.rs", text)]).path(), &["a.rs"]).expect("a hash");
        let first = hash_of("fn one() -> u32 {\n    1\n}\n");
        assert_eq!(hash_of("// One.\n\nfn one() -> u32 {\n1\n}"), first);
        assert_eq!(hash_of("fn one() -> u32 {\n1\n}\n\n#[cfg(test)]\nmod tests {\n    fn two() {}\n}\n"), first);
        assert_ne!(hash_of("fn one() -> u32 {\n    2\n}\n"), first);
        assert_eq!(first.len(), 64);
    }

    #[test]
    fn a_subject_has_what_it_imports_and_no_separate_module_that_it_does_not_name() {
        let module = |name: &str| format!("{VERIFY}/{name}");
        let (units, own, sat, tests, other) = (
            module("units/a.rs"),
            module("units.rs"),
            module("sat/b.rs"),
            module("units/tests.rs"),
            module("other.rs"),
        );
        let files_of = |text: &str| -> Vec<String> {
            let folder = repository(&[
                (&units, text),
                (&own, ""),
                (&sat, ""),
                (&tests, ""),
                (&other, ""),
                ("crates/raypath-hdl/src/lib.rs", "pub mod mutate;"),
                ("crates/raypath-hdl/src/a.rs", ""),
                ("crates/raypath-hdl/src/mutate/b.rs", "use crate::mutate::c;"),
            ]);
            let files = files(folder.path(), &[&module("units"), "crates/raypath-hdl/src"]).expect("files");
            files.into_keys().map(|path| path.replace(VERIFY, "verify")).collect()
        };
        let hdl = ["crates/raypath-hdl/src/a.rs", "crates/raypath-hdl/src/lib.rs"];
        let alone = [&hdl[..], &["verify/units.rs", "verify/units/a.rs"]].concat();
        assert_eq!(files_of("let mutate = 1;"), alone);
        assert_eq!(files_of("use crate::{Error, request::Level};"), alone);
        let with_sat = [&hdl[..], &["verify/sat/b.rs", "verify/units.rs", "verify/units/a.rs"]].concat();
        assert_eq!(files_of("use crate::{Error, sat::Solver};"), with_sat);
        assert_eq!(files_of("use crate::sat::Solver;"), with_sat);
        let mutate = "crates/raypath-hdl/src/mutate/b.rs".to_string();
        assert!(files_of("use raypath_hdl::mutate::all;").contains(&mutate));
        assert!(files_of("use raypath_hdl::{Module, mutate};").contains(&mutate));
    }

    #[test]
    fn a_missing_path_is_an_error() {
        let problem = hash(repository(&[]).path(), &["nothing"]).expect_err("no such path");
        assert!(problem.to_string().contains("nothing"), "{problem}");
    }
}
