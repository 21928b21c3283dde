//! The paper's operations with features that the paper does not have: what is printed, before the tools.

use raypath_lab::rtl::{Accumulators, Config, Control, Features, Lanes, UnitLatency};
use raypath_lab::{Checks, Datapath};
use raypath_ops::Culling;

/// Everything on.
const ALL: Features = Features {
    tag: 32,
    barycentrics: true,
    culling: Culling::None,
    facing: true,
    range: true,
    conservative: true,
    accumulators: Accumulators::Four,
    exception_flags: true,
};

/// Verilator, Yosys and slang have nothing to say, and Verilator shows in every cycle what the cycle-exact model shows.
#[test]
fn all_features_in_verilator() {
    in_verilator(Config { features: ALL, ..Config::DEFAULT });
}

/// The same where beats wait for each other, and jobs for credits.
#[test]
fn all_features_with_credits_and_units_of_two_steps() {
    let config = Config { features: ALL, lanes: Lanes::Four, ..Config::DEFAULT };
    in_verilator(Config { control: Control::Credit, unit_latency: UnitLatency::Two, ..config });
}

fn in_verilator(config: Config) {
    let datapath = Datapath::paper(config);
    let netlist = datapath.elaborate().expect("a datapath");
    let checks = Checks { datapath: &datapath, netlist: &netlist, studies: &[], seed: 8, jobs: 8000 };
    let folder = tempfile::tempdir().expect("a folder");
    let found = checks.in_verilator(folder.path()).expect("the tools are there and content");
    assert!(found.different == 0 && found.cycles > 8000, "{config}: {found:?}");
    let found = checks.against_the_models(|_| true).expect("a netlist");
    assert_eq!((found.jobs, found.different), (8000, 0), "{config}: {:?}", found.differences);
}

/// A feature that cannot be had is refused, and says what could be.
#[test]
fn what_cannot_be_had_is_refused() {
    let features = |features| Datapath::paper(Config { features, ..Config::DEFAULT }).elaborate();
    let error = features(Features { tag: 33, ..Features::OFF }).expect_err("too wide");
    assert!(error.to_string().contains("33 bits, expected 1 to 32"), "{error}");
    let chisel = Config { rules: raypath_ops::Rules::Chisel, features: ALL, ..Config::DEFAULT };
    let error = Datapath::paper(chisel).elaborate().expect_err("not under these rules");
    assert!(error.to_string().contains("expected the rules paper"), "{error}");
}
