//! Units and registers of a datapath, compared with the paper's tables.

use raypath_ops::Rules;
use raypath_rtl::report::picture::pipeline;
use raypath_rtl::report::tables::{difference, schedule, units_and_registers};
use raypath_rtl::{Budget, Config, DatapathNetlist, Lanes, PRESETS, STAGES, Units};

const DEFAULT: Config = Config::DEFAULT;

fn datapath(lanes: Lanes, rules: Rules) -> DatapathNetlist {
    DatapathNetlist::new(Config::DEFAULT.rules(rules).lanes(lanes)).expect("a datapath")
}

fn arithmetic(units: Units) -> (usize, usize, usize) {
    (units.add, units.multiply, units.compare)
}

/// Table VIII of the paper, stage by stage: adders, multipliers, comparators.
const TABLE_VIII: [(usize, usize, usize); 11] = [
    (0, 0, 0),
    (24, 0, 0),
    (0, 24, 0),
    (8, 0, 36),
    (0, 6, 4),
    (4, 0, 0),
    (0, 3, 0),
    (2, 0, 0),
    (2, 0, 0),
    (1, 0, 15), // two quad-sorters of five, and five
    (0, 0, 0),
];

#[test]
fn units_equal_table_viii_or_have_a_reason() {
    let paper: Vec<_> = (1..=STAGES).map(|stage| arithmetic(Budget::TABLE_VIII.units(stage))).collect();
    assert_eq!(paper, TABLE_VIII);
    for rules in [Rules::Paper, Rules::Chisel] {
        let datapath = datapath(Lanes::Sixteen, rules);
        for stage in 1..=STAGES {
            let (ours, paper) = (arithmetic(datapath.units(stage as usize)), TABLE_VIII[stage as usize - 1]);
            let expected = match (rules, stage) {
                (Rules::Paper, 4) => (8, 0, 24), // ruling 1: three signs per box are read, not compared
                (_, 10) => (1, 0, 5),            // one sorting network; ruling 6, or the hit test shares it
                _ => paper,
            };
            assert_eq!(ours, expected, "{rules}, stage {stage}");
        }
    }
}

/// Every stage whose units differ from Table VIII has a reason, and no other stage has one.
#[test]
fn differences_have_reasons() {
    for lanes in [Lanes::Sixteen, Lanes::None] {
        for rules in [Rules::Paper, Rules::Chisel] {
            let (config, datapath) = (Config::DEFAULT.rules(rules).lanes(lanes), datapath(lanes, rules));
            for stage in 1..=STAGES {
                let converts = stage == 1 || stage == STAGES;
                let differs = arithmetic(datapath.units(stage as usize)) != TABLE_VIII[stage as usize - 1];
                let reasons = difference(&datapath, config, stage as usize);
                assert_eq!(differs || converts, !reasons.is_empty(), "{config}, stage {stage}: {reasons:?}");
            }
        }
    }
    let (paper, chisel) = (datapath(Lanes::Sixteen, Rules::Paper), datapath(Lanes::Sixteen, Rules::Chisel));
    assert!(difference(&paper, DEFAULT, 4)[0].starts_with("ruling 1"));
    assert!(difference(&chisel, DEFAULT.rules(Rules::Chisel), 10)[1].contains("shares"));
}

#[test]
fn datapaths_without_distance_modes_have_none_of_their_units() {
    let datapath = datapath(Lanes::None, Rules::Paper);
    let expected =
        [(24, 0, 0), (0, 24, 0), (6, 0, 24), (0, 6, 4), (3, 0, 0), (0, 3, 0), (2, 0, 0), (2, 0, 0), (0, 0, 5)];
    for (stage, expected) in (2..).zip(expected) {
        assert_eq!(arithmetic(datapath.units(stage as usize)), expected, "stage {stage}");
    }
    let ports = datapath.top().inputs().iter().chain(datapath.top().outputs());
    assert!(ports.into_iter().all(|port| !port.name.contains("euclidean") && !port.name.contains("angular")));
    assert_eq!((0..=STAGES).map(|stage| datapath.registers(stage as usize).state).sum::<u64>(), 0);
}

/// The registers hold at most the live bits of a prototype with shared registers, after stages 1 to 10. Comparisons in
/// earlier stages save bits in stages 8 and 9; words and bits of other operations can add a few.
#[test]
fn registers_hold_only_live_bits() {
    let prototype = [1075, 929, 830, 299, 299, 200, 200, 200, 167, 146];
    let datapath = datapath(Lanes::Sixteen, Rules::Paper);
    for (stage, most) in (1..).zip(prototype) {
        let registers = datapath.registers(stage);
        assert!(registers.live <= most + 4, "stage {stage}: {} bits, the prototype had {most}", registers.live);
        assert_eq!((registers.data, registers.control), (2 * registers.live, 2), "stage {stage}");
    }
    let total: u64 = datapath.top().register_bits();
    assert!(total * 100 <= 25_600 * 46, "{total} flip-flops, the original has 25,600");
}

#[test]
fn tables_show_every_stage_and_operation() {
    let datapath = datapath(Lanes::Sixteen, Rules::Paper);
    let (schedule, units) = (schedule(&datapath), units_and_registers(&datapath, DEFAULT));
    for operation in ["quadbox", "triangle", "euclidean", "angular"] {
        assert!(schedule.contains(operation));
    }
    for stage in 1..=STAGES {
        assert!(schedule.lines().any(|line| line.starts_with(&format!("| {stage} "))), "{schedule}");
        assert!(units.lines().any(|line| line.starts_with(&format!("| {stage} "))), "{units}");
    }
    assert!(units.contains(&datapath.top().register_bits().to_string()), "{units}");
}

/// The table of presets in README.md has a row for each preset, with its flip-flops and latency.
#[test]
fn readme_has_the_figures_of_every_preset() {
    let readme = include_str!("../../../README.md");
    for preset in PRESETS {
        let datapath = DatapathNetlist::new(preset.config).expect("a datapath");
        let (bits, latency) = (datapath.top().register_bits(), datapath.latency());
        let figures = format!("| {},{:03} | {latency} |", bits / 1000, bits % 1000);
        let row = readme.lines().find(|line| line.starts_with(&format!("| `{}`", preset.name))).expect("a row");
        assert!(row.contains(&figures), "{figures} is not in {row}");
    }
}

/// The picture in README.md equals that of `generate`.
#[test]
fn picture_in_the_documents_is_current() {
    let drawn = pipeline(&datapath(Lanes::Sixteen, Rules::Paper), DEFAULT);
    let kept = include_str!("../../../docs/images/pipeline.svg");
    assert!(
        drawn == kept,
        "docs/images/pipeline.svg is old: cp build/pipeline.svg docs/ after cargo run --release -- generate"
    );
}
