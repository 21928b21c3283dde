//! The meaning of every port.

use raypath_ops::Culling;
use raypath_oracle::added_operations;
use raypath_oracle::layout::{Field, Layout};
use raypath_rtl::{Accumulators, Config};
use raypath_sim::Datapath;

#[test]
fn every_port_is_known_and_distinct() {
    let features = Config::DEFAULT.tag(3).range(true).culling(Culling::None).accumulators(Accumulators::Four);
    for config in [Config::DEFAULT, features, Config::DEFAULT.quantised_boxes(true)] {
        let added = added_operations();
        let datapath = added.iter().fold(Datapath::paper(config), |all, spec| match config.kinds().len() {
            4.. => all.with_any(spec.operation()),
            _ => all,
        });
        let model = datapath.model();
        let layout = Layout::of(&model);
        for kind in model.kinds() {
            let fields = layout.fields(kind.name());
            assert!(!fields.is_empty() && !fields.contains(&Field::Unknown), "{config}, {kind}: {fields:?}");
            assert!((1..fields.len()).all(|i| !fields[..i].contains(&fields[i])), "{config}, {kind}: {fields:?}");
        }
    }
}
