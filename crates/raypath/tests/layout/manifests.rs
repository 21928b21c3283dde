//! The permitted dependencies between crates, and the requirements of Cargo for packages.

use crate::layout::{root, text};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// Names of the packages that each crate of the workspace depends on, by kind: "normal", "dev" or "build".
type Dependencies = BTreeMap<String, BTreeMap<String, BTreeSet<String>>>;

fn cargo(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO")).args(arguments).current_dir(root()).output().expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

/// The packages of the workspace, in the form of `cargo metadata`.
fn packages() -> Vec<Value> {
    let metadata = cargo(&["metadata", "--format-version", "1", "--no-deps", "--offline"]);
    let mut metadata: Value = serde_json::from_str(&metadata).expect("JSON");
    serde_json::from_value(metadata["packages"].take()).expect("packages")
}

pub fn dependencies() -> Dependencies {
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

/// The crates of the workspace that `name` reaches through normal dependencies, optional ones included.
fn reached(all: &Dependencies, name: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut open = vec![name.to_string()];
    while let Some(name) = open.pop() {
        for next in all[&name].get("normal").into_iter().flatten().filter(|next| all.contains_key(*next)) {
            if found.insert(next.clone()) {
                open.push(next.clone());
            }
        }
    }
    found
}

/// Crates that describe operations depend on no tools, files or options, so that an added operation compiles fast.
#[test]
fn operations_depend_on_no_tool() {
    let all = dependencies();
    let normal: Vec<&str> = all["raypath-ops"]["normal"].iter().map(String::as_str).collect();
    assert_eq!(normal, ["thiserror"], "raypath-ops");
    let model = reached(&all, "raypath-model");
    assert!(
        model.iter().all(|name| name == "raypath-ops" || name == "raypath-float" || name == "raypath-hdl"),
        "{model:?}"
    );
}

/// Each layer depends only on those below it.
#[test]
fn layers_depend_downwards() {
    let layers = [
        &["raypath-ops", "raypath-hdl"][..],
        &["raypath-float", "raypath-wave"],
        &["raypath-model", "raypath-rtl", "raypath-tools"],
        &["raypath-sim", "raypath-timing", "raypath-ppa", "raypath-unit"],
        &["raypath-oracle", "raypath-render", "raypath-search", "raypath-fpga"],
        &["raypath-verify", "raypath-embed"],
        &["raypath-capi"],
        &["raypath-cli"],
        &["raypath", "raypath-python", "raypath-fuzz"],
        &["within_radius"],
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

/// Units do not depend on the crate that verifies them; neither does the facade's library.
#[test]
fn verification_is_above_what_it_verifies() {
    let all = dependencies();
    for (name, kinds) in &all {
        let may = ["raypath", "raypath-cli", "raypath-fuzz", "raypath-verify"].contains(&name.as_str());
        let knows = kinds.values().flatten().any(|dependency| dependency == "raypath-verify");
        assert!(may || !knows, "{name} depends on raypath-verify");
    }
    assert!(!all["raypath"]["normal"].contains("raypath-verify"), "the facade depends on raypath-verify");
}

/// The crates that `cargo run --release -- generate` compiles, including those of this workspace.
#[test]
fn the_first_command_compiles_at_most_100_crates() {
    let tree = cargo(&["tree", "-p", "raypath", "-e", "normal,build", "--prefix", "none", "--offline", "--locked"]);
    let crates: BTreeSet<&str> = tree.lines().filter_map(|line| line.split(" (").next()).map(str::trim).collect();
    assert!(crates.len() <= 100, "{} crates: {crates:#?}", crates.len());
}

/// After `./test.sh`, README's commands compile no dependency again, nor does the wheel: the builds select the same
/// features. The wheel does not compile the crates of the workspace again either.
#[test]
fn all_builds_share_their_dependencies() {
    let features = |arguments: &[&str]| -> BTreeSet<String> {
        let tree =
            cargo(&[&["tree", "--format", "{p} {f}", "--prefix", "none", "--offline", "--locked"], arguments].concat());
        tree.lines().map(|line| line.replace(" (*)", "").replace(" (proc-macro)", "")).collect()
    };
    let tests = features(&["--workspace", "-e", "normal,build,dev"]);
    let is_of_workspace = |line: &str| line.contains(" (");
    for chosen in [&["raypath"][..], &["raypath", "--features", "full"], &["raypath-python"], &["raypath-capi"]] {
        let build = features(&[&["-e", "normal,build", "-p"], chosen].concat());
        let is_wheel = chosen == ["raypath-python"];
        let again: Vec<&String> = build.difference(&tests).filter(|line| is_wheel || !is_of_workspace(line)).collect();
        assert!(
            again.is_empty(),
            "features that the tests do not select; select them in raypath-tools/Cargo.toml: {again:#?}"
        );
    }
}

/// The requirements of `cargo package` on each published crate: its dependencies in the workspace have a version and
/// are published, and it has a description and a licence. Dev-dependencies in the workspace have no version, so that
/// Cargo omits them from the package, where they would form cycles.
#[test]
fn crates_can_be_packaged() {
    let packages = packages();
    let name = |value: &Value| value["name"].as_str().expect("a name").to_string();
    // `publish` is null for crates that may be published, and empty for the others.
    let published: BTreeMap<String, &Value> = packages
        .iter()
        .filter(|package| package["publish"].is_null())
        .map(|package| (name(package), package))
        .collect();
    assert!(published.contains_key("raypath") && published.contains_key("raypath-ops"), "{published:?}");
    for (package, manifest) in &published {
        for field in ["description", "license"] {
            assert!(manifest[field].is_string(), "{package} has no {field}");
        }
        for dependency in manifest["dependencies"].as_array().expect("dependencies") {
            if dependency["path"].is_null() {
                continue;
            }
            let (on, has_version) = (name(dependency), dependency["req"] != "*");
            if dependency["kind"] == "dev" {
                assert!(!has_version, "{package}: the dev-dependency on {on} has a version, expected a path alone");
            } else {
                assert!(has_version, "{package}: the dependency on {on} has no version");
                assert!(published.contains_key(&on), "{package} depends on {on}, which is not published");
            }
        }
    }
    let manifest = text(&root().join("Cargo.toml"));
    assert!(!manifest.contains("[patch"), "a patch holds in this workspace alone");
}
