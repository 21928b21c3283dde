//! Documents that must keep up with the code.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Every dependency is defended by name in `docs/dependencies.md`, and nothing else is.
#[test]
fn every_dependency_is_defended() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut used = BTreeSet::new();
    for entry in fs::read_dir(root.join("crates")).expect("crates") {
        let manifest = entry.expect("an entry").path().join("Cargo.toml");
        let text = fs::read_to_string(&manifest).expect("a manifest");
        let mut lists_dependencies = false;
        for line in text.lines() {
            if line.starts_with('[') {
                lists_dependencies = line.ends_with("dependencies]");
            } else if lists_dependencies && let Some((name, _)) = line.split_once(['.', ' ', '=']) {
                used.insert(name.to_string());
            }
        }
    }
    used.retain(|name| !name.starts_with("raypath"));
    assert!(used.contains("clap") && used.contains("wellen"), "{used:?}");

    let document = fs::read_to_string(root.join("docs/dependencies.md")).expect("the document");
    let crates = document.split("## Programs").next().expect("the crates");
    let rows = crates.lines().filter(|line| line.starts_with("| `"));
    let mut defended = BTreeSet::new();
    for row in rows {
        let names = row.split('|').nth(1).expect("a first column");
        let names: Vec<&str> = names.split('`').skip(1).step_by(2).filter(|name| !name.starts_with('=')).collect();
        // `cranelift-jit`, `-module`: parts of one family are written short.
        let family = names[0].split_once('-').map_or(names[0], |(family, _)| family);
        defended.extend(names.iter().map(|name| match name.starts_with('-') {
            true => format!("{family}{name}"),
            false => name.to_string(),
        }));
    }
    assert_eq!(used, defended);
}
