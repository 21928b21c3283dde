//! The paper's operations with additional features: the emitted SystemVerilog in the tools, and oracles.

use rand::RngExt;
use raypath_float::Format;
use raypath_ops::{Culling, EdgeRule, Ray, RayTriangleExtended, RayTriangleExtendedInput, Rules, Triangle};
use raypath_oracle::{AnyOperationSpec, Checks, OperationSpec};
use raypath_rtl::{Accumulators, Config, Control, Features, Lanes, UnitLatency};
use raypath_sim::Datapath;
use std::collections::BTreeSet;

/// All features.
const ALL: Features = Features {
    tag: 32,
    barycentrics: true,
    edges: EdgeRule::Shared,
    culling: Culling::None,
    facing: true,
    range: true,
    conservative: true,
    quantised_boxes: false,
    accumulators: Accumulators::Four,
    exception_flags: true,
};

/// Verilator, Yosys and slang report nothing, and Verilator agrees with the cycle-exact model in every cycle.
#[test]
#[ignore = "run by ./test.sh --long"]
fn all_features_in_verilator() {
    in_verilator(Config::DEFAULT.features(ALL));
}

/// The same with accumulators that take several cycles, and with credits.
#[test]
#[ignore = "run by ./test.sh --long"]
fn all_features_with_credits_and_units_of_two_steps() {
    let config = Config::DEFAULT.features(ALL).lanes(Lanes::Two);
    in_verilator(config.control(Control::Credit).unit_latency(UnitLatency::TWO));
}

fn in_verilator(config: Config) {
    let datapath = Datapath::paper(config);
    let netlist = datapath.elaborate().expect("a datapath");
    let checks = Checks { datapath: &datapath, netlist: &netlist, specs: &[], seed: 8, jobs: 8000 };
    let folder = tempfile::tempdir().expect("a folder");
    let found = checks.in_verilator(folder.path()).expect("no report from the tools");
    assert!(found.different == 0 && found.cycles > 8000, "{config}: {found:?}");
    let found = checks.against_the_models(|_| true).expect("a netlist");
    assert_eq!((found.jobs + found.lost, found.different), (8000, 0), "{config}: {:?}", found.differences);
}

#[test]
fn unsupported_features_are_errors() {
    let features = |features| Datapath::paper(Config::DEFAULT.features(features)).elaborate();
    let error = features(Features { tag: 33, ..Features::OFF }).expect_err("too wide");
    assert!(error.to_string().contains("33 bits, expected 1 to 32"), "{error}");
    let flags = Features { exception_flags: true, ..Features::OFF };
    let half = Config::DEFAULT.format(Format::BINARY16).features(flags);
    let error = Datapath::paper(half).elaborate().expect_err("no model has them");
    assert!(error.to_string().contains("expected format fp32"), "{error}");
    let quantised = Features { quantised_boxes: true, ..Features::OFF };
    let chisel = Config::DEFAULT.rules(Rules::Chisel).features(quantised);
    let error = Datapath::paper(chisel).elaborate().expect_err("not under these rules");
    assert!(error.to_string().contains("expected rules paper"), "{error}");
}

/// An oracle gets all other ports correctly if optional ports are absent. The tag is a random word.
#[test]
fn oracles_get_the_present_ports() {
    let extended = RayTriangleExtended { culling: Culling::None, facing: true, ..RayTriangleExtended::PLAIN };
    let spec = OperationSpec::of(extended)
        .stimulus(|rng| {
            let mut vertex = || [(); 3].map(|()| rng.random_range(-1.0_f32..1.0));
            let triangle = Triangle::new(vertex(), vertex(), vertex());
            let ray = Ray::new([0.0, 0.0, -5.0], [0.0, 0.0, 1.0], f32::INFINITY).expect("a ray");
            RayTriangleExtendedInput { ray, triangle, t_min: 7.0.into() }
        })
        .oracle("the sign of the denominator", |job, answer| {
            if f32::from(job.t_min) != 0.0 {
                return Err("an absent port has a value".to_string());
            }
            let is_front = f32::from(answer.t_denom) > 0.0;
            if bool::from(answer.facing) == is_front { Ok(()) } else { Err(format!("front: {is_front}")) }
        });
    let specs = [AnyOperationSpec::from(spec)];
    let datapath = Datapath::new().tag(8).with_any(specs[0].operation());
    let netlist = datapath.elaborate().expect("a datapath");
    let checks = Checks { datapath: &datapath, netlist: &netlist, specs: &specs, seed: 9, jobs: 1000 };
    let reports = &checks.against_the_oracles()[0];
    assert_eq!((reports.jobs, reports.wrong), (1000, 0), "{reports:?}");
    let model = datapath.model();
    let kind = model.kind("triangle").expect("its operation");
    assert!(model.inputs(kind).iter().all(|port| port.name != "t_min"));
    let tags: BTreeSet<u64> =
        checks.transactions(&specs[0]).iter().filter_map(|found| found.job.as_words().last().copied()).collect();
    assert!(tags.len() > 200, "{} of 256 tags", tags.len());
    assert_eq!(checks.against_the_models(|_| true).expect("a netlist").different, 0);
}
