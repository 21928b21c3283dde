//! libFuzzer on a target, whose name is in the environment variable `RAYPATH_FUZZ`. `fuzz/run.sh` builds and runs it.

#![no_main]

#[path = "../../crates/raypath-capi/tests/hostile/calls.rs"]
mod calls;

use libfuzzer_sys::fuzz_target;
use raypath_fuzz::TARGETS;
use std::sync::OnceLock;

static TARGET: OnceLock<fn(&[u8]) -> bool> = OnceLock::new();

fuzz_target!(|bytes: &[u8]| {
    TARGET.get_or_init(target)(bytes);
});

/// The function of the target.
fn target() -> fn(&[u8]) -> bool {
    let name = std::env::var("RAYPATH_FUZZ").unwrap_or_default();
    if name == "c_interface" {
        return calls::calls;
    }
    let found = TARGETS.iter().find(|target| target.name == name);
    found.map_or_else(|| panic!("RAYPATH_FUZZ is '{name}', expected a folder of fuzz/corpus"), |target| target.parse)
}
