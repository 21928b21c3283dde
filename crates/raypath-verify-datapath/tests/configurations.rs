//! Configurations: the netlist equals the cycle-exact model in every cycle, every outcome equals that of the functional
//! model, and latency and throughput are as documented.

use rayon::prelude::*;
use raypath_ops::Rounding;
use raypath_rtl::{Config, Features, Lanes};
use raypath_sim::Datapath;
use raypath_sim::engine::NetlistEngine;
use raypath_sim::lockstep::RegressionChecks;
use raypath_verify_datapath::covering::{Space, presets_and_pairs};

#[test]
fn presets_and_every_pair_of_values() {
    let configs = presets_and_pairs(&Space::new(&|_| true));
    configs.par_iter().enumerate().for_each(|(seed, &config)| {
        let model = Datapath::paper(config).model();
        let mut netlist = NetlistEngine::new(model.clone(), config, RegressionChecks::observes)
            .unwrap_or_else(|error| panic!("{config}: {error}"));
        let checks = RegressionChecks { config, seed: seed as u64, jobs: 2000 };
        checks
            .check(&mut netlist, &model)
            .unwrap_or_else(|failed| panic!("{config}, {}: {}", failed.check, failed.what));
    });
}

/// Sums that round once shorten the pipeline, unless an operation computes something in the stages that they save.
#[test]
fn sums_that_round_once_shorten_the_pipeline() {
    let latency = |config: Config| Datapath::paper(config).elaborate().expect("a datapath").latency();
    let sum = Config::DEFAULT.rounding(Rounding::Sum);
    assert_eq!(
        [Config::DEFAULT, sum, sum.lanes(Lanes::SixtyFour), sum.lanes(Lanes::None)].map(latency),
        [12, 10, 10, 10]
    );
    assert_eq!(latency(sum.features(Features { range: true, ..Features::OFF })), 12);
}
