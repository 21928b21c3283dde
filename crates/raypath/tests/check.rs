//! The comparison that `generate` prints: that it finds nothing where nothing is, and something where something is.

use raypath::check::lockstep;
use raypath::engine::NetlistEngine;
use raypath::format::Format;
use raypath::jobs::random;
use raypath::model::Functional;
use raypath::ops::{Job, JobKind, Rules};
use raypath::rtl::Config;
use raypath::traffic::Traffic;

const JOBS: usize = 2000;

fn netlist(rules: Rules) -> NetlistEngine {
    NetlistEngine::new(Functional::new(rules), Config { rules, ..Config::DEFAULT }, |_| false).expect("a datapath")
}

fn jobs() -> impl Iterator<Item = Job> {
    random(&Functional::new(Rules::Paper), Format::BINARY32, 4, &JobKind::ALL).take(JOBS)
}

#[test]
fn the_same_rules_agree() {
    for rules in [Rules::Paper, Rules::Chisel] {
        let found = lockstep(&mut netlist(rules), Functional::new(rules), jobs(), &mut Traffic::random(5), |_| true);
        assert_eq!((found.jobs, found.different, found.by_kind.iter().sum::<usize>()), (JOBS, 0, JOBS));
        assert!(found.cycles > JOBS as u64 && found.stalled > 0, "{found:?}");
    }
}

/// A netlist with the other rules answers some jobs otherwise; after a hundred differences nobody wants more.
#[test]
fn other_rules_differ() {
    let found =
        lockstep(&mut netlist(Rules::Chisel), Functional::new(Rules::Paper), jobs(), &mut Traffic::random(5), |_| true);
    assert!(found.different >= 100 && found.jobs < JOBS, "{} differences in {} jobs", found.different, found.jobs);
    assert_eq!(found.differences.len(), 5);
    assert!(found.differences[0].contains("Quadbox") || found.differences[0].contains("Triangle"));
}

#[test]
fn whoever_watches_may_stop_it() {
    let found =
        lockstep(&mut netlist(Rules::Paper), Functional::new(Rules::Paper), jobs(), &mut Traffic::always(), |done| {
            done < 10
        });
    assert_eq!((found.jobs, found.different), (10, 0));
}
