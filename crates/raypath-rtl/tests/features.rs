//! Features of the paper's operations, and of all operations.

mod exceptions;
mod options;

use crate::common::driver::compare;
use raypath_ops::PortKind;
use raypath_rtl::{Config, DatapathNetlist};
use raypath_sim::{Datapath, Words, jobs};

/// Compares a configuration's netlist with its models, for random jobs.
fn check(config: Config, count: usize) {
    let model = Datapath::paper(config).model();
    let jobs: Vec<Words> = jobs::random(&model, config.semantics.format, 1, config.kinds()).take(count).collect();
    let seen = compare(config, &DatapathNetlist::new(config).expect("a datapath"), &model, &jobs);
    // Every flag was both 0 and 1, so a constant flag would be found.
    for port in model.kinds().iter().flat_map(|&kind| model.outputs(kind)).filter(|port| port.kind == PortKind::Flags) {
        let values = &seen[&port.name];
        let (ones, always) = values.iter().fold((0, u64::MAX), |(ones, always), bits| (ones | bits, always & bits));
        assert!(ones != 0 && always == 0, "{config}: {} never changes: {values:?}", port.name);
    }
}
