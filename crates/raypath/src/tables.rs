//! The datapath in tables: schedule (Table VII), units (Table VIII) and registers, all computed from the netlist.

use comfy_table::{ContentArrangement, Table, presets};
use raypath_ops::Rules;
use raypath_rtl::{Config, Datapath, Lanes, STAGES, StageNote, UnitKind, Units};

/// Table VIII of the paper, for stages 1 to 11 with 16 lanes; the two quad-sorters of stage 10 count five comparators
/// each. Conversions stand outside it.
pub const PAPER_UNITS: [Units; STAGES as usize] = [
    units(0, 0, 0),
    units(24, 0, 0),
    units(0, 24, 0),
    units(8, 0, 36),
    units(0, 6, 4),
    units(4, 0, 0),
    units(0, 3, 0),
    units(2, 0, 0),
    units(2, 0, 0),
    units(1, 0, 15),
    units(0, 0, 0),
];

const fn units(add: usize, multiply: usize, compare: usize) -> Units {
    Units { encode: 0, add, multiply, compare, decode: 0 }
}

/// Table VII: what each operation does in each stage.
pub fn schedule(datapath: &Datapath) -> String {
    let mut table = new_table();
    let operations: Vec<&str> = datapath.schedule(1).iter().map(|note| note.operation).collect();
    table.set_header([&["stage"], operations.as_slice()].concat());
    for stage in 1..=STAGES {
        let mut row = vec![stage.to_string()];
        row.extend(datapath.schedule(stage).iter().map(cell));
        table.add_row(row);
    }
    table.to_string()
}

fn cell(note: &StageNote) -> String {
    let units = list(note.units);
    match (units.is_empty(), note.what.is_empty()) {
        (true, _) => note.what.clone(),
        (_, true) => units,
        _ => format!("{units}: {}", note.what),
    }
}

/// Table VIII with the paper's figures beside ours, and the registers after each stage.
pub fn units_and_registers(datapath: &Datapath, config: Config) -> String {
    let mut table = new_table();
    table.set_header(["stage", "units", "Table VIII", "live bits", "flip-flops", "why the units differ"]);
    let (mut all, mut live, mut flip_flops) = (Units::default(), 0, 0);
    for stage in 0..=STAGES {
        let registers = datapath.registers(stage);
        let units = datapath.units(stage);
        all = sum(all, units);
        live += registers.live;
        flip_flops += registers.flip_flops();
        table.add_row([
            if stage == 0 { "input".to_string() } else { stage.to_string() },
            list(units),
            list(paper_units(stage)),
            registers.live.to_string(),
            registers.flip_flops().to_string(),
            difference(datapath, config, stage).join("; "),
        ]);
    }
    let paper = PAPER_UNITS.into_iter().fold(Units::default(), sum);
    table.add_row(["all".to_string(), list(all), list(paper), live.to_string(), flip_flops.to_string(), String::new()]);
    table.to_string()
}

/// Why a stage has other units than Table VIII gives it; empty where it has the same.
pub fn difference(datapath: &Datapath, config: Config, stage: u32) -> Vec<&'static str> {
    let (ours, paper) = (datapath.units(stage), paper_units(stage));
    let mut causes = Vec::new();
    if ours.encode + ours.decode > 0 {
        causes.push("conversion, which Table VIII leaves out");
    }
    if ours.add != paper.add && config.lanes == Lanes::None {
        causes.push("no distance modes");
    }
    if ours.compare != paper.compare {
        causes.extend(match (stage, config.rules) {
            (4, Rules::Paper) => &["ruling 1: the sign of inv is read, not compared"][..],
            (10, Rules::Paper) => {
                &["one sorting network moves values and indices", "ruling 6: the hit test reads signs"]
            }
            (10, Rules::Chisel) => {
                &["one sorting network moves values and indices", "the hit test shares its comparators"]
            }
            _ => &[],
        });
    }
    causes
}

fn paper_units(stage: u32) -> Units {
    stage.checked_sub(1).and_then(|index| PAPER_UNITS.get(index as usize).copied()).unwrap_or_default()
}

/// Units in words, `24 add, 4 compare`; empty where there are none.
pub fn list(units: Units) -> String {
    let named = UnitKind::ALL.into_iter().map(|kind| (units.of(kind), kind.stem()));
    let present: Vec<String> =
        named.filter(|(number, _)| *number > 0).map(|(number, stem)| format!("{number} {stem}")).collect();
    present.join(", ")
}

fn sum(a: Units, b: Units) -> Units {
    Units {
        encode: a.encode + b.encode,
        add: a.add + b.add,
        multiply: a.multiply + b.multiply,
        compare: a.compare + b.compare,
        decode: a.decode + b.decode,
    }
}

pub(crate) fn new_table() -> Table {
    let mut table = Table::new();
    table.load_preset(presets::ASCII_MARKDOWN).set_content_arrangement(ContentArrangement::Dynamic);
    if table.width().is_none() {
        table.set_width(140);
    }
    table
}
