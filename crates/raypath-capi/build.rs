//! Gives the shared library the name under which programs load it, `libraypath.so.` and the version of the ABI, and
//! states the commit that it is built from.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("linux") {
        println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libraypath.so.1");
    }
    // A package from a registry has no repository.
    if let Some(commit) = git(&["rev-parse", "HEAD"]).filter(|_| Path::new("../../Cargo.lock").exists()) {
        println!("cargo::rustc-env=RAYPATH_COMMIT={commit}");
    }
    // The log of HEAD changes with each commit and checkout.
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"]).filter(|log| Path::new(log).exists()) {
        println!("cargo::rerun-if-changed={log}");
    }
}

/// What a command of Git prints. None if it fails, or if Git is missing.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_string())
}
