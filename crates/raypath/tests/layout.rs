//! Two rules of the layout (`docs/development/architecture.md`): crates depend on lower layers only, and the first
//! command compiles few crates.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// Each layer depends only on those below it.
#[test]
fn layers_depend_downwards() {
    let layers = [
        &["raypath-ops", "raypath-hdl"][..],
        &["raypath-float"],
        &["raypath-model", "raypath-rtl", "raypath-tools"],
        &["raypath-sim", "raypath-timing", "raypath-traversal", "raypath-work"],
        &["raypath-oracle", "raypath-scene", "raypath-search", "raypath-ppa"],
        &["raypath-embed", "raypath-fpga", "raypath-render", "raypath-verify"],
        &["raypath-verify-arithmetic", "raypath-verify-traversal"],
        &["raypath-verify-datapath"],
        &["raypath-verify-mutation"],
        &["raypath-capi"],
        &["raypath-cli"],
        &["raypath", "raypath-python", "raypath-fuzz"],
        &["within_radius"],
        &["within_radius_bindings"],
    ];
    let all = dependencies();
    let layer = |name: &str| layers.iter().position(|layer| layer.contains(&name));
    for (name, kinds) in &all {
        let own = layer(name)
            .unwrap_or_else(|| panic!("{name} has no layer: add it to this test and to the architecture page"));
        for below in kinds.get("normal").into_iter().flatten().filter(|below| all.contains_key(*below)) {
            assert!(layer(below) < Some(own), "{name} depends on {below}, which is not in a lower layer");
        }
    }
}

/// The crates that `cargo run --release -- generate` compiles, including those of this workspace.
#[test]
fn the_first_command_compiles_at_most_100_crates() {
    let tree = cargo(&["tree", "-p", "raypath", "-e", "normal,build", "--prefix", "none", "--offline", "--locked"]);
    let crates: BTreeSet<&str> = tree.lines().filter_map(|line| line.split(" (").next()).map(str::trim).collect();
    assert!(crates.len() <= 100, "{} crates: {crates:#?}", crates.len());
}

/// Names of the packages that each crate of the workspace depends on, by kind: "normal", "dev" or "build".
type Dependencies = BTreeMap<String, BTreeMap<String, BTreeSet<String>>>;

fn cargo(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO"))
        .args(arguments)
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

/// The packages of the workspace, in the form of `cargo metadata`.
fn packages() -> Vec<Value> {
    let metadata = cargo(&["metadata", "--format-version", "1", "--no-deps", "--offline"]);
    let mut metadata: Value = serde_json::from_str(&metadata).expect("JSON");
    serde_json::from_value(metadata["packages"].take()).expect("packages")
}

fn dependencies() -> Dependencies {
    let mut all = Dependencies::new();
    for package in packages() {
        let of = all.entry(package["name"].as_str().expect("a name").to_string()).or_default();
        for dependency in package["dependencies"].as_array().expect("dependencies") {
            let kind = dependency["kind"].as_str().unwrap_or("normal").to_string();
            of.entry(kind).or_default().insert(dependency["name"].as_str().expect("a name").to_string());
        }
    }
    all
}
