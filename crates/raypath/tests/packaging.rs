//! The crates can be packaged for a registry.

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

/// The requirements of `cargo package` on each published crate: its dependencies in the workspace have a version and
/// are published, and it has a description and a licence. Dev-dependencies in the workspace have no version, so that
/// Cargo omits them from the package, where they would form cycles.
#[test]
fn crates_can_be_packaged() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut cargo = Command::new(env!("CARGO"));
    let output = cargo
        .args(["metadata", "--no-deps", "--offline", "--format-version", "1"])
        .current_dir(&root)
        .output()
        .expect("cargo metadata");
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let packages = metadata["packages"].as_array().expect("packages");
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
    let manifest = std::fs::read_to_string(root.join("Cargo.toml")).expect("the manifest");
    assert!(!manifest.contains("[patch"), "a patch holds in this workspace alone");
}
