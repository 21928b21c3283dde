//! States the commit that the program is built from, and whether the sources differ from it.

use std::path::Path;
use std::process::Command;

/// What the program is built from, relative to this package. A change there runs this script again.
const SOURCES: [&str; 3] = ["../../crates", "../../Cargo.toml", "../../Cargo.lock"];

fn main() {
    // A package from a registry has neither the workspace nor a repository.
    let is_workspace = Path::new("../../Cargo.lock").exists();
    let commit = git(&["rev-parse", "HEAD"]).filter(|_| is_workspace);
    for source in SOURCES.iter().filter(|source| Path::new(source).exists()) {
        println!("cargo::rerun-if-changed={source}");
    }
    println!("cargo::rerun-if-changed=build.rs");
    // The log of HEAD changes with each commit and checkout.
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"]).filter(|log| Path::new(log).exists()) {
        println!("cargo::rerun-if-changed={log}");
    }
    if let Some(commit) = commit {
        let changes = git(&[&["status", "--porcelain", "--"], &SOURCES[..]].concat());
        println!("cargo::rustc-env=RAYPATH_COMMIT={commit}");
        if let Some(digest) = git(&["hash-object", "../../Cargo.lock"]) {
            println!("cargo::rustc-env=RAYPATH_LOCK={digest}");
        }
        println!("cargo::rustc-env=RAYPATH_CLEAN={}", changes.is_some_and(|changes| changes.is_empty()));
    }
}

/// What a command of Git prints. None if it fails, or if Git is missing.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_string())
}
