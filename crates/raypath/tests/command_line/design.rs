//! What `generate` writes for the flow of a system, and `raypath card`.

use crate::command_line::{ends_with, file, folder, page, raypath, said, text};
use serde_json::Value;
use std::process::Command;

/// Constraints, IP-XACT and the card agree with the emitted text, by Python, tclsh and OpenSTA.
#[test]
fn constraints_component_and_card_are_those_of_the_text() {
    let unit = "--unit --unit-features instances --queries full --address-width 40 --preset compact";
    let cases = [
        ("raypath", "7.5", "--preset compact --clock-gating"),
        ("raypath", "12", "--with sphere --interval 2"),
        ("raypath_unit_axi", "10", unit),
    ];
    for (module, period, options) in cases {
        let (folder, options) = (folder(), options.split(' ').collect::<Vec<_>>());
        let out = text(folder.path());
        let generated = page::succeeds(&[&["generate", "--out", &out, "--period", period], &options[..]].concat());
        file(folder.path(), "generate.txt", generated);
        file(folder.path(), "card.json", page::succeeds(&[&["card"], &options[..]].concat()));
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/command_line/design.py");
        let output = Command::new("python3").args([script, &out, module, period]).output().expect("python3");
        assert!(output.status.success(), "{options:?}: {}", said(&output));
    }
}

/// The idle energy of a cycle of a job does not count twice: 2 x 100 of 500 pJ. 100 pJ in 10 ns are 10 mW.
#[test]
fn cards_are_read_converted_and_refused() {
    let folder = folder();
    let made = page::succeeds(&["card", "--lanes", "none", "--interval", "2"]);
    let bare = file(folder.path(), "bare.json", &made);
    let mut card: Value = serde_json::from_str(&made).expect("a card");
    card["measured"] =
        serde_json::json!({"library": "l", "synthesis": "s", "timing": "t", "area_um2": 2e6, "clock_ns": 10});
    card["idle_pj_per_cycle"] = 100.into();
    card["operations"]["triangle"]["pj_per_job"] = 500.into();
    card["operations"]["quadbox"]["pj_per_job"] = 500.into();
    let whole = file(folder.path(), "whole.json", card.to_string());
    card["card_version"] = 2.into();
    let other = file(folder.path(), "other.json", card.to_string());

    let read = |path, reader, code, words: &[&str]| ends_with(&["card", "--from", path, "--as", reader], code, words);
    let idle = r#"<param name="raypath_idle_power" value="1.00000e-2"/>"#;
    read(&whole, "accelwattch", 0, &[r#"<param name="RAYPATH_QUADBOX_ACC" value="3.00000e-10"/>"#, idle]);
    let energy = r#"<param name="raypath_triangle_energy_per_access" value="3.00000e-10"/>"#;
    read(&whole, "mcpat", 0, &[energy, r#"<stat name="raypath_triangle_accesses" value="0"/>"#, idle]);
    // design.py compares the latency with that of the netlist.
    let latency = card["latency_cycles"].as_u64().expect("cycles");
    let line = format!("\n-gpgpu_rt_intersection_latency 4,{},8,4,{latency},{latency},8\n", latency + 2);
    read(&bare, "gpgpu-sim", 0, &[&line]);
    read(&bare, "mcpat", 2, &["the card has no /measured/clock_ns: not measured", "card --liberty FILE"]);
    read(&other, "mcpat", 2, &["other.json: card: card_version is 2, expected 1"]);
    ends_with(&["card", "--unit", "--as", "gpgpu-sim"], 2, &["no /latency_cycles: depends on the ray"]);
    ends_with(&["card", "--power"], 2, &["--power", "expected --liberty"]);
}

/// The measured figures are those of `ppa`, and the flip-flops those that Yosys finds.
#[test]
#[ignore = "long: a synthesis and a simulation of gates"]
fn a_card_has_the_figures_of_ppa() {
    let folder = folder();
    let below = |name: &str| text(&folder.path().join(name));
    let library = "/usr/share/qflow/tech/osu018/osu018_stdcells.lib";
    let [cache, out] = ["cache", "ppa"].map(below);
    let options = ["--preset", "compact", "--power", "--stream", "16", "--cache", &cache, "--liberty", library];
    let json = |command: &[&str]| -> Value {
        serde_json::from_slice(&raypath(&[command, &options].concat()).stdout).expect("JSON")
    };
    let (report, card) = (json(&["ppa", "--json", "--out", &out]), json(&["card"]));
    let workloads = report["power"]["workloads"].as_array().expect("workloads");
    let of = |name: &str, field: &str| &workloads.iter().find(|found| found["name"] == name).expect(name)[field];
    assert_eq!(card["measured"]["area_um2"], report["area"]["total"]);
    assert_eq!(card["measured"]["clock_ns"], report["slowest"]["ns"]);
    assert_eq!([&card["register_bits"], &card["memory_bits"]], [&report["flip_flops"], &report["memory_bits"]]);
    assert_eq!(card["idle_pj_per_cycle"], *of("idle", "picojoules_per_cycle"));
    for name in ["triangle", "quadbox"] {
        let energy = of(&format!("{name} of the picture"), "picojoules_per_job");
        assert_eq!(card["operations"][name]["pj_per_job"], *energy);
    }
}
