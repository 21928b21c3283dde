//! A datapath with the paper's operations and all added ones.

use raypath_oracle::{AnyOperationSpec, Checks, added_operations};
use raypath_rtl::{Config, Control, Encoding, Lanes, Sharing, UnitLatency};
use raypath_sim::Datapath;

fn with_all(config: Config, specs: &[AnyOperationSpec]) -> Datapath {
    specs.iter().fold(Datapath::paper(config), |datapath, spec| datapath.with_any(spec.operation()))
}

#[test]
fn every_operation_has_a_specification_with_an_oracle() {
    let all = added_operations();
    assert_eq!(all.iter().map(AnyOperationSpec::name).collect::<Vec<_>>(), raypath_ops::operations::NAMES);
    assert!(all.iter().all(|spec| spec.oracle_name().is_some() && !spec.purpose().is_empty()));
}

/// Three linters report nothing, and the outcomes in Verilator agree with the oracles.
#[test]
fn verilator_agrees_with_the_oracles() {
    let specs = added_operations();
    let datapath = with_all(Config::DEFAULT.lanes(Lanes::Two), &specs);
    let netlist = datapath.elaborate().expect("they fit");
    assert_eq!(netlist.latency(), 12);
    let checks = Checks { datapath: &datapath, netlist: &netlist, specs: &specs, seed: 5, jobs: 10_000 };
    let folder = tempfile::tempdir().expect("a folder");
    let found = checks.in_verilator(folder.path()).expect("no report from the tools");
    assert_eq!(found.different, 0, "{:?}", found.faults);
    assert_eq!(found.reports.len(), specs.len());
    for (reports, spec) in found.reports.iter().zip(&specs) {
        assert!(reports.wrong == 0 && reports.jobs > 500, "{}: {reports:?}", spec.name());
    }
}

#[test]
fn the_netlist_agrees_with_the_models_in_several_configurations() {
    let specs = added_operations();
    let default = Config::DEFAULT;
    let configurations = [
        default,
        default.control(Control::Credit).unit_latency(UnitLatency::TWO),
        default.unit_latency(UnitLatency::THREE),
        default.io(Encoding::Recoded).registers(Encoding::Ieee).sharing(Sharing::Segregated),
        default.format(raypath_float::Format::BINARY16),
    ];
    for config in configurations {
        let datapath = with_all(config, &specs);
        let netlist = datapath.elaborate().expect("they fit");
        let checks = Checks { datapath: &datapath, netlist: &netlist, specs: &specs, seed: 6, jobs: 4000 };
        let found = checks.against_the_models(|_| true).expect("a netlist");
        assert_eq!((found.jobs + found.lost, found.different), (4000, 0), "{config}: {:?}", found.differences);
        assert!(found.by_opcode.len() == 4 + specs.len() && found.stalled > 100, "{config}: {found:?}");
    }
}
