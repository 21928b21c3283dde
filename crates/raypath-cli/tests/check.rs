//! The comparison of `generate`: it finds no difference in a correct netlist, and finds deliberate faults.

use raypath_float::Format;
use raypath_model::{Model, WordModel, Words};
use raypath_ops::{JobKind, Rules};
use raypath_rtl::{Config, DatapathNetlist, Encoding};
use raypath_sim::engine::{Engine, NetlistEngine};
use raypath_sim::jobs::random;
use raypath_sim::lockstep::lockstep;
use raypath_sim::traffic::{Cycle, Traffic};

const JOBS: usize = 2000;

fn netlist(rules: Rules) -> NetlistEngine {
    NetlistEngine::new(model(rules), Config::DEFAULT.rules(rules), |_| false).expect("a datapath")
}

fn model(rules: Rules) -> WordModel {
    raypath_sim::Datapath::paper(Config::DEFAULT.rules(rules)).model()
}

fn jobs() -> impl Iterator<Item = Words> {
    random(&model(Rules::Paper), Format::BINARY32, 4, &JobKind::ALL).take(JOBS)
}

/// Bubbles, stalls, withdrawn jobs and resets at any time.
#[test]
fn the_same_rules_agree_through_events() {
    for rules in [Rules::Paper, Rules::Chisel] {
        let mut resets = 0;
        for seed in 0..8 {
            let mut traffic = Traffic::eventful(seed, 12_000, 1);
            let mut events = traffic.clone();
            resets += (0..12_000).filter(|_| events.next_cycle().resets).count();
            let jobs = random(&model(rules), Format::BINARY32, seed, &JobKind::ALL).take(12_000);
            let found = lockstep(&mut netlist(rules), model(rules), jobs, &mut traffic, |_| true);
            assert_eq!(found.different, 0, "{rules}, seed {seed}: {:?}", found.differences);
        }
        assert!(resets > 100, "{resets}");
    }
}

/// A reset in the cycle of each handshake, and several resets in a row.
#[test]
fn the_same_rules_agree_through_resets_at_every_moment_of_a_burst() {
    let mut netlist = netlist(Rules::Paper);
    for moment in 0..50 {
        let cycle = |cycle| Cycle {
            offers: cycle < 60,
            takes: cycle % 3 != 0 && !(15..30).contains(&cycle),
            withdraws: false,
            resets: [moment, moment + 1, moment + 20].contains(&cycle),
        };
        netlist.reset();
        let mut traffic = Traffic::recorded((0..90).map(cycle).collect());
        let found = lockstep(&mut netlist, model(Rules::Paper), jobs().take(64), &mut traffic, |_| true);
        assert_eq!(found.different, 0, "reset at {moment}: {:?}", found.differences);
    }
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
    let datapath = DatapathNetlist::new(Config::DEFAULT).expect("a datapath");
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
