//! Import cycles between the files of a crate.

use crate::layout::{files, root, text};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The maximum number of files in an import cycle: a type, its constructor and its parts.
const MAX_CYCLE: usize = 3;

/// The path of a module inside its crate: `["engine", "netlist"]` for `crate::engine::netlist`.
type Module = Vec<String>;

/// The modules that each module of a crate imports from.
type Imports = BTreeMap<Module, BTreeSet<Module>>;

#[test]
fn no_import_cycle_has_more_than_three_files() {
    let mut faults = Vec::new();
    for entry in std::fs::read_dir(root().join("crates")).expect("a folder") {
        let folder = entry.expect("a crate").path();
        for cycle in cycles(&imports(&folder.join("src"))).into_iter().filter(|cycle| cycle.len() > MAX_CYCLE) {
            let names: Vec<String> = cycle.iter().map(|module| module.join("::")).collect();
            faults.push(format!("{}: {} files: {}", folder.display(), cycle.len(), names.join(", ")));
        }
    }
    assert!(faults.is_empty(), "import cycles of more than {MAX_CYCLE} files:\n{}", faults.join("\n"));
}

#[test]
fn a_cycle_is_found() {
    let module = |name: &str| vec![name.to_string()];
    let imports: Imports = [("a", "b"), ("b", "c"), ("c", "a"), ("d", "a")]
        .into_iter()
        .map(|(from, to)| (module(from), BTreeSet::from([module(to)])))
        .collect();
    let mut found = cycles(&imports);
    found.retain(|cycle| cycle.len() > 1);
    assert_eq!(found, [vec![module("a"), module("b"), module("c")]]);
}

#[test]
fn paths_are_read_from_nested_imports() {
    let text = "use crate::{a::{B, c::D}, e};\nlet x = crate::f::g();";
    let expected = ["crate::a::B", "crate::a::c::D", "crate::e", "crate::f::g"];
    assert_eq!(paths(text), expected.map(String::from).into());
}

/// The imports of the files below `src`. An import of a name that the root re-exports counts as one of its module.
fn imports(src: &Path) -> Imports {
    let sources: BTreeMap<Module, String> =
        files(src, "rs").into_iter().map(|file| (module(src, &file), code(&file))).collect();
    let root = sources.get(&Module::new()).map(String::as_str).unwrap_or_default();
    let exported: BTreeMap<String, Module> = paths(root)
        .into_iter()
        .filter_map(|path| {
            let mut names: Module = path.split("::").map(String::from).collect();
            names.retain(|name| name != "crate" && name != "self");
            let name = names.last()?.clone();
            Some((name, of_path(&names, &sources)?))
        })
        .collect();
    let mut imports = Imports::new();
    for (from, text) in sources.iter().filter(|(from, _)| !from.is_empty()) {
        for path in paths(text) {
            let names: Module = path.split("::").map(String::from).collect();
            let Some(names) = absolute(from, &names, &sources) else { continue };
            let to = of_path(&names, &sources).or_else(|| exported.get(names.first()?).cloned());
            if let Some(to) = to.filter(|to| to != from && !to.is_empty()) {
                imports.entry(from.clone()).or_default().insert(to);
            }
        }
    }
    imports
}

/// The module of a file: `main.rs` and `lib.rs` are the root.
fn module(src: &Path, file: &Path) -> Module {
    let path = file.strip_prefix(src).expect("below src").with_extension("");
    let names = path.iter().map(|name| name.to_string_lossy().into_owned());
    names.filter(|name| !["lib", "main", "mod"].contains(&name.as_str())).collect()
}

/// A file's text without comments and unit tests.
fn code(file: &Path) -> String {
    let text = text(file);
    let text = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// The paths that begin with `crate`, `self`, `super` or a name after `use`, with nested imports written out.
fn paths(text: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for statement in text.split(';') {
        let import = statement.rfind("use ").filter(|&at| {
            statement[..at].trim_end().ends_with(['}', ')', ']']) || {
                let before = statement[..at].trim_end();
                before.is_empty() || before.ends_with("pub") || before.ends_with('\n')
            }
        });
        if let Some(at) = import {
            expand("", statement[at + 4..].trim(), &mut found);
        }
        for start in ["crate::", "super::"] {
            for (at, _) in statement.match_indices(start) {
                let is_name = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
                let path: String = statement[at..].chars().take_while(|&c| is_name(c)).collect();
                if !path.ends_with("::") {
                    found.insert(path);
                }
            }
        }
    }
    found
}

/// Writes out `a::{b, c::d}` as `a::b` and `a::c::d`.
fn expand(prefix: &str, text: &str, found: &mut BTreeSet<String>) {
    let text = text.trim();
    match text.find('{') {
        Some(open) => {
            let prefix = format!("{prefix}{}", &text[..open]);
            let inner = text[open + 1..].strip_suffix('}').unwrap_or(&text[open + 1..]);
            let (mut depth, mut begin) = (0, 0);
            for (at, c) in inner.char_indices().chain([(inner.len(), ',')]) {
                match c {
                    '{' => depth += 1,
                    '}' => depth -= 1,
                    ',' if depth == 0 => {
                        expand(&prefix, &inner[begin..at], found);
                        begin = at + 1;
                    }
                    _ => {}
                }
            }
        }
        None if text.is_empty() => {}
        None => {
            let name = text.split(" as ").next().unwrap_or_default();
            found.insert(format!("{prefix}{name}").trim_end_matches("::self").to_string());
        }
    }
}

/// A path from the crate's root; none if it leads to another crate.
fn absolute(from: &Module, names: &[String], sources: &BTreeMap<Module, String>) -> Option<Module> {
    let mut base = from.clone();
    let mut names = names.iter().peekable();
    match names.peek()?.as_str() {
        "crate" => {
            names.next();
            base.clear();
        }
        "self" => {
            names.next();
        }
        "super" => {
            while names.next_if(|name| *name == "super").is_some() {
                base.pop();
            }
        }
        child => {
            let mut module = from.clone();
            module.push(child.to_string());
            sources.get(&module)?;
        }
    }
    base.extend(names.cloned());
    Some(base)
}

/// The longest beginning of a path that is a module of its own file.
fn of_path(names: &[String], sources: &BTreeMap<Module, String>) -> Option<Module> {
    (1..=names.len()).rev().map(|length| names[..length].to_vec()).find(|module| sources.contains_key(module))
}

/// The strongly connected components: modules that reach each other.
fn cycles(imports: &Imports) -> Vec<Vec<Module>> {
    let reach = |from: &Module| {
        let mut found = BTreeSet::new();
        let mut open = vec![from.clone()];
        while let Some(module) = open.pop() {
            for next in imports.get(&module).into_iter().flatten() {
                if found.insert(next.clone()) {
                    open.push(next.clone());
                }
            }
        }
        found
    };
    let reached: BTreeMap<&Module, BTreeSet<Module>> = imports.keys().map(|module| (module, reach(module))).collect();
    let mut found: Vec<Vec<Module>> = Vec::new();
    for (&module, others) in &reached {
        if found.iter().any(|cycle| cycle.contains(module)) {
            continue;
        }
        let is_mutual = |other: &&Module| reached.get(other).is_some_and(|back| back.contains(module));
        let mut cycle: Vec<Module> = others.iter().filter(is_mutual).cloned().collect();
        if !cycle.contains(module) {
            cycle.insert(0, module.clone());
        }
        found.push(cycle);
    }
    found
}
