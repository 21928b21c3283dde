//! Comparison of a netlist with its models, for random jobs.

use raypath_rtl::{Config, DatapathNetlist};
use raypath_sim::engine::{NetlistEngine, evaluate};
use raypath_sim::lockstep::lockstep;
use raypath_sim::traffic::Traffic;
use raypath_sim::{WordModel, Words};
use std::collections::{BTreeMap, BTreeSet};

/// Sends jobs through a netlist, with random pauses of source and sink, and compares its ports with those of the models
/// in each cycle. Returns the values that each output port had.
pub fn compare(
    config: Config,
    datapath: &DatapathNetlist,
    model: &WordModel,
    jobs: &[Words],
) -> BTreeMap<String, BTreeSet<u64>> {
    let mut netlist = NetlistEngine::of(model.clone(), config, datapath, |_| false).expect("a netlist");
    let found = lockstep(&mut netlist, model.clone(), jobs.iter().cloned(), &mut Traffic::random(1), |_| true);
    assert_eq!((found.jobs, found.different), (jobs.len(), 0), "{config}: {:#?}", found.differences);
    let mut seen: BTreeMap<String, BTreeSet<u64>> = BTreeMap::new();
    evaluate(model.clone(), jobs.iter(), |_, outcome| {
        for port in model.outputs(outcome.kind()) {
            seen.entry(port.name.clone()).or_default().insert(outcome.port(&port.name));
        }
        true
    });
    seen
}
