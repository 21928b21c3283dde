//! The comparison of `generate`: it finds no difference in a correct netlist, and finds deliberate faults.

use raypath::float::Format;
use raypath::model::{Model, WordModel, Words};
use raypath::ops::{JobKind, Rules};
use raypath::rtl::{Config, Datapath, Encoding};
use raypath::sim;
use raypath::sim::engine::{Engine, NetlistEngine};
use raypath::sim::jobs::random;
use raypath::sim::lockstep::lockstep;
use raypath::sim::traffic::Traffic;

const JOBS: usize = 2000;

fn netlist(rules: Rules) -> NetlistEngine {
    NetlistEngine::new(model(rules), Config::DEFAULT.rules(rules), |_| false).expect("a datapath")
}

fn model(rules: Rules) -> WordModel {
    sim::Datapath::paper(Config::DEFAULT.rules(rules)).model()
}

fn jobs() -> impl Iterator<Item = Words> {
    random(&model(Rules::Paper), Format::BINARY32, 4, &JobKind::ALL).take(JOBS)
}

#[test]
fn the_same_rules_agree() {
    for rules in [Rules::Paper, Rules::Chisel] {
        let found = lockstep(&mut netlist(rules), model(rules), jobs(), &mut Traffic::random(5), |_| true);
        assert_eq!((found.jobs, found.different, found.by_opcode.values().sum::<usize>()), (JOBS, 0, JOBS));
        assert!(found.cycles > JOBS as u64 && found.stalled > 0, "{found:?}");
    }
}

/// A netlist with the other rules differs for some jobs; the comparison stops after a hundred differences.
#[test]
fn other_rules_differ() {
    let found = lockstep(&mut netlist(Rules::Chisel), model(Rules::Paper), jobs(), &mut Traffic::random(5), |_| true);
    assert!(found.different >= 100 && found.jobs < JOBS, "{} differences in {} jobs", found.different, found.jobs);
    assert_eq!(found.differences.len(), 5);
    assert!(found.differences[0].contains("quadbox") || found.differences[0].contains("triangle"));
}

/// Ports with a wrong encoding are named: ports of other operations, wrong numbers, and all numbers if they are read in
/// another encoding.
#[test]
fn improper_outputs_are_named() {
    let model = model(Rules::Paper);
    let mut netlist = netlist(Rules::Paper);
    let kind = |kind: JobKind| model.kind(kind.name()).expect("one of the paper's");
    let ones = |of: JobKind| model.job(kind(of), |_| 0x3f80_0000);
    netlist.present(&ones(JobKind::Euclidean));
    let shown = (0..20).find_map(|_| netlist.cycle(true, true).output).expect("an outcome");
    assert_eq!(netlist.improper_outputs(&shown), [""; 0]);
    let other = model.outcome(kind(JobKind::Euclidean), |name| match name {
        "euclidean_accumulator" => 0x3f80_0000,
        name => shown.port(name),
    });
    let improper = netlist.improper_outputs(&other);
    assert_eq!(improper, ["euclidean_accumulator_o is 0, expected 3f800000"]);
    let boxes = model.clone().run(&ones(JobKind::Quadbox));
    assert!(netlist.improper_outputs(&boxes).iter().any(|port| port == "is_intersect_o is 0, expected f"));

    let recoded = Config::DEFAULT.io(Encoding::Recoded);
    let datapath = Datapath::new(Config::DEFAULT).expect("a datapath");
    let mut misread = NetlistEngine::of(model.clone(), recoded, &datapath, |_| false).expect("an engine");
    let found = lockstep(&mut misread, model, jobs(), &mut Traffic::always(), |_| true);
    assert!(found.different >= 100, "{} differences", found.different);
}

#[test]
fn the_observer_can_stop_the_comparison() {
    let found =
        lockstep(&mut netlist(Rules::Paper), model(Rules::Paper), jobs(), &mut Traffic::always(), |done| done < 10);
    assert_eq!((found.jobs, found.different), (10, 0));
}
