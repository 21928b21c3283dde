//! The counts of lines and branches, on a module whose counts are known.

use raypath_hdl::Builder;
use raypath_tools::{CoverageKind, Options, Sources, Verilated};

/// How often each point of a register with an enable is reached, of inputs below 2.
#[test]
fn lines_and_branches_are_counted() {
    let m = Builder::new("held");
    let held = m.register("held_q", 2).reset_to(0);
    held.next_when(m.input("load_i", 1), m.input("value_i", 2));
    m.output("held_o", held.wire());
    let (top, folder) = (m.finish().expect("a module"), tempfile::tempdir().expect("a folder"));
    let files = Sources::write(&top, folder.path()).expect("sources").files;
    let options = Options { coverage: true, ..Options::default() };
    let verilated = Verilated::build_sources(&files, &top, folder.path(), &options).expect("a build");
    let hits = |loads: u64, kind: CoverageKind, name: &str| -> Vec<u64> {
        // Reset, load, the value.
        let frames = (0..10).map(|cycle| vec![1, loads, cycle % 2]);
        let mut seen = Vec::new();
        let points = verilated.coverage(frames, |_, outputs| seen.push(outputs[0])).expect("a run");
        let expected: Vec<u64> =
            (0..10).map(|cycle| if loads == 1 && cycle > 0 { (cycle - 1) % 2 } else { 0 }).collect();
        assert_eq!(seen, expected);
        assert!(points.iter().all(|point| point.module == "held"));
        let named = points.into_iter().filter(|point| point.kind == kind && point.name == name);
        named.map(|point| point.hits).collect()
    };
    let loading = hits(1, CoverageKind::Branch, "if");
    let holding = hits(0, CoverageKind::Branch, "if");
    assert!(loading != holding && !loading.is_empty(), "{loading:?} {holding:?}");
    assert!(!hits(1, CoverageKind::Line, "block").is_empty());
}
