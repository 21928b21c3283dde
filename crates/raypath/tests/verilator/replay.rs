//! The printed datapath, in Verilator, in every cycle like the cycle-exact model; so the golden vectors hold there too.

use crate::frames::{Answers, Cycle, Stimulus};
use crate::recorded::golden;
use raypath::hdl::Module;
use raypath::jobs::random;
use raypath::model::Functional;
use raypath::ops::{Job, JobKind, Outcome, Rules};
use raypath::rtl::{Config, Datapath, Lanes};
use raypath::traffic::{Traffic, interleave};
use raypath_cosim::Verilated;

fn build(config: Config) -> (tempfile::TempDir, Datapath, Verilated) {
    let datapath = Datapath::new(config).expect("a datapath");
    let folder = tempfile::tempdir().expect("a folder");
    let verilated = Verilated::build(datapath.top(), folder.path()).expect("a build");
    (folder, datapath, verilated)
}

/// Runs cycles in Verilator and gives the number of those that differ from the model's.
fn faults(verilated: &Verilated, top: &Module, cycles: &[Cycle]) -> usize {
    let mut faults = 0;
    let mut seen = 0;
    verilated
        .run(cycles.iter().map(|cycle| cycle.inputs.clone()), |index, values| {
            seen += 1;
            if let Some(fault) = cycles[index].expected.as_ref().and_then(|expected| expected.fault(top, values)) {
                faults += 1;
                if faults <= 3 {
                    eprintln!("cycle {index}: {fault}");
                }
            }
        })
        .expect("a simulation");
    assert_eq!(seen, cycles.len());
    faults
}

/// The golden vectors: in the recorded order without stalls, with stalls and bubbles, and with the modes interleaved.
#[test]
fn golden_vectors() {
    let (_folder, datapath, verilated) = build(Config { rules: Rules::Chisel, ..Config::DEFAULT });
    let recorded = golden();
    let mixed = interleave(recorded.clone(), 11);
    for (stream, traffic) in [
        (&recorded, Traffic::always()),
        (&recorded, Traffic::random(12)),
        (&mixed, Traffic::always()),
        (&mixed, Traffic::random(13)),
    ] {
        let jobs: Vec<Job> = stream.iter().map(|transaction| transaction.job).collect();
        let outcomes: Vec<Outcome> = stream.iter().map(|transaction| transaction.expected).collect();
        let answers = Answers::Recorded(&outcomes);
        let cycles = Stimulus { jobs: &jobs, answers, traffic, resets: vec![] }.cycles(datapath.top());
        assert_eq!(faults(&verilated, datapath.top(), &cycles), 0);
    }
    // The comparison can fail: one wrong bit in the record is found.
    let jobs: Vec<Job> = recorded[..100].iter().map(|transaction| transaction.job).collect();
    let mut outcomes: Vec<Outcome> = recorded[..100].iter().map(|transaction| transaction.expected).collect();
    let ports = outcomes[60].ports();
    outcomes[60] = Outcome::from_ports(outcomes[60].kind(), |name| {
        ports.iter().find(|port| port.name == name).map_or(0, |port| port.bits) ^ 1
    });
    let answers = Answers::Recorded(&outcomes);
    let cycles = Stimulus { jobs: &jobs, answers, traffic: Traffic::always(), resets: vec![] }.cycles(datapath.top());
    assert_eq!(faults(&verilated, datapath.top(), &cycles), 1);
}

/// Random jobs of all modes under the rules `paper`, with resets at any moment, against the models.
#[test]
fn random_jobs_and_resets() {
    random_campaign(Lanes::Sixteen, &JobKind::ALL);
}

/// The same without distance modes.
#[test]
fn random_jobs_and_resets_without_distance_modes() {
    random_campaign(Lanes::None, &[JobKind::Triangle, JobKind::Quadbox]);
}

fn random_campaign(lanes: Lanes, kinds: &[JobKind]) {
    let (_folder, datapath, verilated) = build(Config { lanes, ..Config::DEFAULT });
    let jobs: Vec<Job> = random(21, kinds).take(20_000).collect();
    for seed in 0..2 {
        let resets = (0..40).map(|n| 500 + n * 997 + n * n).collect();
        let answers = Answers::Model(Functional::new(Rules::Paper));
        let stimulus = Stimulus { jobs: &jobs, answers, traffic: Traffic::random(seed), resets };
        let cycles = stimulus.cycles(datapath.top());
        assert_eq!(faults(&verilated, datapath.top(), &cycles), 0, "seed {seed}");
    }
}
