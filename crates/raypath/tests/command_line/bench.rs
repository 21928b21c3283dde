//! `raypath bench`.

use crate::command_line::{folder, raypath, said, text};

#[test]
fn rates_are_printed_and_written() {
    let folder = folder();
    let out = folder.path().join("bench.json");
    let output = raypath(&["bench", "--quick", "--json", "--no-verilator", "--out", &text(&out)]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let printed: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let written: serde_json::Value = serde_json::from_slice(&std::fs::read(&out).expect("a file")).expect("JSON");
    assert_eq!(printed, written);
    let rates = printed["rates"].as_array().expect("rates");
    let of = |what: &str| rates.iter().find(|rate| rate["what"].as_str().is_some_and(|name| name.contains(what)));
    for what in [
        "functional model, mixed jobs",
        "quadbox",
        "euclidean",
        "cycle-exact model, the sink stalls",
        "netlist, compiled",
        "netlist, compiling",
        "unpacking",
        "rays from origin",
        "rays from the eye",
        "exact search",
    ] {
        let rate = of(what).unwrap_or_else(|| panic!("no rate of {what}"));
        assert!(rate["per_second"].as_f64().expect("a number") > 1.0, "{rate}");
    }
    assert_eq!(of("rays from the eye").expect("rays")["peer"][0], "obvhs");
    let growth = printed["growth"].as_array().expect("growth");
    assert!(growth.len() >= 3 && growth.iter().all(|of| of["points"].as_array().is_some_and(|all| all.len() >= 3)));
}
