//! The printed datapath in Verilator equals the cycle-exact model in every cycle.

use crate::recorded::golden;
use crate::verilator::representatives::REPRESENTATIVES;
use rayon::prelude::*;
use raypath_hdl::Module;
use raypath_model::Words;
use raypath_ops::Rules;
use raypath_rtl::{Config, DatapathNetlist, Lanes};
use raypath_sim::engine::{PortEncoding, shape};
use raypath_sim::frames::{Answers, Cycle, Stimulus};
use raypath_sim::jobs::random;
use raypath_sim::traffic::{Traffic, interleave};
use raypath_tools::{Options, Sources, Verilated};

/// A datapath in Verilator, with the assertions of its control bound.
fn build(config: Config) -> (tempfile::TempDir, DatapathNetlist, Verilated) {
    let datapath = DatapathNetlist::new(config).expect("a datapath");
    let folder = tempfile::tempdir().expect("a folder");
    let (top, path) = (datapath.top(), folder.path());
    let mut sources = Sources::write(top, path).expect("sources");
    sources.add(path.join("raypath_properties.sv"), &datapath.properties().to_string()).expect("the assertions");
    let verilated = Verilated::build_sources(&sources.files, top, path, &Options::default()).expect("a build");
    (folder, datapath, verilated)
}

/// Runs cycles in Verilator and returns the number that differs from the model.
fn faults(verilated: &Verilated, top: &Module, cycles: Vec<Cycle>) -> usize {
    let (inputs, expected): (Vec<_>, Vec<_>) = cycles.into_iter().map(|cycle| (cycle.inputs, cycle.expected)).unzip();
    let mut faults = 0;
    let mut seen = 0;
    verilated
        .run_randomly(7, inputs, |index, values| {
            seen += 1;
            if let Some(fault) = expected[index].as_ref().and_then(|expected| expected.fault(top, values)) {
                faults += 1;
                if faults <= 3 {
                    eprintln!("cycle {index}: {fault}");
                }
            }
        })
        .expect("a simulation");
    assert_eq!(seen, expected.len());
    faults
}

/// The golden vectors: in the recorded order without stalls, with stalls and bubbles, and with the modes interleaved.
#[test]
fn golden_vectors() {
    let config = Config::DEFAULT.rules(Rules::Chisel);
    let (_folder, datapath, verilated) = build(config);
    let recorded = golden();
    let mixed = interleave(recorded.clone(), |transaction| transaction.job.kind().opcode(), 11);
    let faults_of = |jobs: &[Words], outcomes: &[Words], traffic: Traffic| {
        let (shape, encoding) = (shape(config, &datapath), PortEncoding::of(config));
        let answers = Answers::Recorded(outcomes);
        let stimulus = Stimulus { shape, encoding, jobs, answers, traffic, resets: vec![] };
        faults(&verilated, datapath.top(), stimulus.cycles(datapath.top()))
    };
    for (stream, traffic) in [
        (&recorded, Traffic::always()),
        (&recorded, Traffic::random(12)),
        (&mixed, Traffic::always()),
        (&mixed, Traffic::random(13)),
    ] {
        let jobs: Vec<Words> = stream.iter().map(|transaction| transaction.job.clone()).collect();
        let outcomes: Vec<Words> = stream.iter().map(|transaction| transaction.expected.clone()).collect();
        assert_eq!(faults_of(&jobs, &outcomes, traffic), 0);
    }
    // Negative control: one wrong bit in the record is found.
    let jobs: Vec<Words> = recorded[..100].iter().map(|transaction| transaction.job.clone()).collect();
    let mut outcomes: Vec<Words> = recorded[..100].iter().map(|transaction| transaction.expected.clone()).collect();
    let wrong: Vec<u64> = outcomes[60].as_words().iter().map(|word| word ^ 1).collect();
    outcomes[60] = raypath_sim::Datapath::paper(config).model().outcome_of_words(outcomes[60].kind(), &wrong);
    assert_eq!(faults_of(&jobs, &outcomes, Traffic::always()), 1);
}

/// Random jobs of all modes with resets at any moment, against the models, with every value of every parameter. Of this
/// the item `text-coverage` runs a part each day.
#[test]
#[ignore = "run by ./test.sh --long"]
fn random_jobs_and_resets() {
    let default = Config::DEFAULT;
    REPRESENTATIVES.into_par_iter().chain([default, default.lanes(Lanes::None)]).for_each(random_campaign);
}

fn random_campaign(config: Config) {
    let (_folder, datapath, verilated) = build(config);
    let model = raypath_sim::Datapath::paper(config).model();
    let jobs: Vec<Words> = random(&model, config.semantics.format, 21, config.kinds()).take(10_000).collect();
    for seed in 0..2 {
        let stimulus = Stimulus {
            shape: shape(config, &datapath),
            encoding: PortEncoding::of(config),
            jobs: &jobs,
            answers: Answers::Model(model.clone()),
            traffic: Traffic::random(seed),
            resets: (0..40).map(|n| 500 + n * 997 + n * n).collect(),
        };
        let cycles = stimulus.cycles(datapath.top());
        assert_eq!(faults(&verilated, datapath.top(), cycles), 0, "{config}, seed {seed}");
    }
}
