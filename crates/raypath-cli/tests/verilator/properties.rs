//! The assertions of `generate` in Verilator: they hold in the design, and fail in a design with a fault.

use raypath_rtl::{Config, DatapathNetlist, Lanes};
use raypath_tools::{Options, Sources, ToolError, Verilated};

/// Runs 500 cycles with stalls and bubbles and arbitrary data, from registers with random values, which are reset in
/// cycle 20. `fault` replaces a text in `raypath_skid`.
fn simulate(fault: Option<(&str, &str)>) -> Result<(), ToolError> {
    let config = Config::DEFAULT.lanes(Lanes::None).format("e3s3".parse().expect("a format"));
    let datapath = DatapathNetlist::new(config).expect("a datapath");
    let top = datapath.top();
    let folder = tempfile::tempdir().expect("a folder");
    let mut sources = Sources::write(top, folder.path()).expect("sources");
    if let Some((from, to)) = fault {
        let skid = folder.path().join("raypath_skid.sv");
        let text = std::fs::read_to_string(&skid).expect("text");
        assert!(text.contains(from), "{from}");
        std::fs::write(&skid, text.replace(from, to)).expect("a file");
    }
    let path = folder.path().join("raypath_properties.sv");
    sources.add(path, &datapath.properties().to_string()).expect("the assertions");
    let verilated = Verilated::build_sources(&sources.files, top, folder.path(), &Options::default())?;
    let mut state = 1u64;
    let frames = (0..500).map(|cycle| {
        let mut frame = vec![u64::from(cycle != 20)];
        for port in top.inputs() {
            // Knuth's 64-bit linear congruential generator; its upper bits are used.
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            frame.push((state >> 33) & (u64::MAX >> (64 - top.signal(port.signal).width)));
        }
        frame
    });
    let frames: Vec<_> = frames.collect();
    verilated.run_from_power_up(1, frames, |_, _| ())
}

#[test]
fn assertions_hold_in_the_design_and_fail_with_a_fault() {
    simulate(None).expect("no assertion fails");
    assert!(simulate(Some(("= leaves & refill", "= refill"))).is_err(), "a front that is overwritten while it waits");
}
