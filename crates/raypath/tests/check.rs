//! The comparison that `generate` prints: that it finds nothing where nothing is, and something where something is.

use raypath::check::lockstep;
use raypath::engine::NetlistEngine;
use raypath::jobs::random;
use raypath::ops::{JobKind, Rules};
use raypath::rtl::Config;
use raypath::traffic::Traffic;

const JOBS: usize = 2000;

fn netlist(rules: Rules) -> NetlistEngine {
    NetlistEngine::new(Config { rules, ..Config::DEFAULT }, |_| false).expect("a datapath")
}

#[test]
fn the_same_rules_agree() {
    for rules in [Rules::Paper, Rules::Chisel] {
        let jobs = random(4, &JobKind::ALL).take(JOBS);
        let found = lockstep(&mut netlist(rules), rules, jobs, &mut Traffic::random(5), |_| true);
        assert_eq!((found.jobs, found.different, found.by_kind.iter().sum::<usize>()), (JOBS, 0, JOBS));
        assert!(found.cycles > JOBS as u64 && found.stalled > 0, "{found:?}");
    }
}

/// A netlist with the other rules answers some jobs otherwise; after a hundred differences nobody wants more.
#[test]
fn other_rules_differ() {
    let jobs = random(4, &JobKind::ALL).take(JOBS);
    let found = lockstep(&mut netlist(Rules::Chisel), Rules::Paper, jobs, &mut Traffic::random(5), |_| true);
    assert!(found.different >= 100 && found.jobs < JOBS, "{} differences in {} jobs", found.different, found.jobs);
    assert_eq!(found.differences.len(), 5);
    assert!(found.differences[0].contains("Quadbox") || found.differences[0].contains("Triangle"));
}

#[test]
fn whoever_watches_may_stop_it() {
    let jobs = random(4, &JobKind::ALL).take(JOBS);
    let found = lockstep(&mut netlist(Rules::Paper), Rules::Paper, jobs, &mut Traffic::always(), |done| done < 10);
    assert_eq!((found.jobs, found.different), (10, 0));
}
