//! All operations of this crate beside the paper's four, as hardware.

use raypath_lab::rtl::{Config, Control, Encoding, Sharing, UnitLatency};
use raypath_lab::{AnyStudy, Checks, Datapath, registered};

// Nothing here names an operation: what is linked in has registered itself.
use raypath_extra as _;

fn with_all(config: Config, studies: &[AnyStudy]) -> Datapath {
    studies.iter().fold(Datapath::paper(config), |datapath, study| datapath.with_any(study.operation()))
}

#[test]
fn every_operation_has_registered_itself_with_an_oracle() {
    let all = registered();
    let entries = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/src/operations")).expect("a folder");
    let names = entries.map(|entry| entry.expect("a file").file_name().to_string_lossy().into_owned());
    let mut files: Vec<String> = names.filter_map(|name| name.strip_suffix(".rs").map(String::from)).collect();
    files.sort();
    assert_eq!(all.iter().map(AnyStudy::name).collect::<Vec<_>>(), files);
    assert!(all.iter().all(|study| study.verified_by().is_some() && !study.for_what().is_empty()));
}

/// Past three linters, then in Verilator, all answers before the operations' oracles.
#[test]
fn verilator_answers_like_the_oracles() {
    let studies = registered();
    let datapath = with_all(Config::DEFAULT, &studies);
    let netlist = datapath.elaborate().expect("they fit");
    assert_eq!(netlist.latency(), 12);
    let checks = Checks { datapath: &datapath, netlist: &netlist, studies: &studies, seed: 5, jobs: 10_000 };
    let folder = tempfile::tempdir().expect("a folder");
    let found = checks.in_verilator(folder.path()).expect("the tools are there and content");
    assert_eq!(found.different, 0, "{:?}", found.faults);
    assert_eq!(found.judged.len(), studies.len());
    for (judged, study) in found.judged.iter().zip(&studies) {
        assert!(judged.wrong == 0 && judged.jobs > 500, "{}: {judged:?}", study.name());
    }
}

/// Netlist, cycle-exact and functional model in every cycle, however the datapath is built.
#[test]
fn the_netlist_is_like_the_models_in_every_configuration() {
    let studies = registered();
    let default = Config::DEFAULT;
    let configurations = [
        default,
        Config { control: Control::Credit, unit_latency: UnitLatency::Two, ..default },
        Config { unit_latency: UnitLatency::Three, ..default },
        Config { io: Encoding::Recoded, registers: Encoding::Ieee, sharing: Sharing::Segregated, ..default },
        Config { format: raypath_float::Format::BINARY16, ..default },
    ];
    for config in configurations {
        let datapath = with_all(config, &studies);
        let netlist = datapath.elaborate().expect("they fit");
        let checks = Checks { datapath: &datapath, netlist: &netlist, studies: &studies, seed: 6, jobs: 4000 };
        let found = checks.against_the_models(|_| true).expect("a netlist");
        assert_eq!((found.jobs, found.different), (4000, 0), "{config}: {:?}", found.differences);
        assert!(found.by_opcode.len() == 4 + studies.len() && found.stalled > 100, "{config}: {found:?}");
    }
}
