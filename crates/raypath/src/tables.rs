//! The datapath in tables: schedule (Table VII), units (Table VIII) and registers, all computed from the netlist.

use comfy_table::{ContentArrangement, Table, presets};
use raypath_ops::Rules;
use raypath_rtl::{Datapath, Lanes, Registers, STAGES, StageNote, UnitKind, Units};

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
pub fn units_and_registers(datapath: &Datapath) -> String {
    let mut table = new_table();
    table.set_header(["stage", "units", "Table VIII", "live bits", "flip-flops", "why the units differ"]);
    let mut total = Registers::default();
    for stage in 0..=STAGES {
        let registers = datapath.registers(stage);
        let flip_flops = registers.data + registers.control + registers.state;
        total.data += flip_flops;
        total.live += registers.live;
        let paper = stage.checked_sub(1).map(|index| PAPER_UNITS[index as usize]).unwrap_or_default();
        table.add_row([
            if stage == 0 { "input".to_string() } else { stage.to_string() },
            list(datapath.units(stage)),
            list(paper),
            registers.live.to_string(),
            flip_flops.to_string(),
            difference(datapath, stage).to_string(),
        ]);
    }
    let all = (1..=STAGES).map(|stage| datapath.units(stage)).fold(Units::default(), sum);
    table.add_row([
        "all".to_string(),
        list(all),
        list(PAPER_UNITS.into_iter().fold(Units::default(), sum)),
        total.live.to_string(),
        total.data.to_string(),
        String::new(),
    ]);
    table.to_string()
}

/// Why a stage has other units than Table VIII gives it; empty where it has the same.
pub fn difference(datapath: &Datapath, stage: u32) -> &'static str {
    let config = datapath.config();
    match (stage, config.lanes, config.rules) {
        (1 | 11, _, _) => "conversion, which Table VIII leaves out",
        (4, Lanes::Sixteen, Rules::Paper) => "ruling 1: the sign of inv is read, not compared (12 fewer)",
        (4, Lanes::None, Rules::Paper) => "ruling 1 (12 comparators fewer); no sums of 16 lanes (2 adders fewer)",
        (4, Lanes::None, Rules::Chisel) => "no sums of 16 lanes (2 fewer)",
        (6, Lanes::None, _) => "no sums of 16 lanes (1 fewer)",
        (10, lanes, rules) => match (rules, lanes) {
            (Rules::Paper, Lanes::Sixteen) => {
                "one network's 5 comparators move values and indices; ruling 6: the hit test reads signs (5 fewer)"
            }
            (Rules::Paper, Lanes::None) => {
                "one network's 5 comparators move values and indices; ruling 6 (5 fewer); no accumulator"
            }
            (Rules::Chisel, Lanes::Sixteen) => {
                "one network's 5 comparators move values and indices, and serve the hit test as well"
            }
            (Rules::Chisel, Lanes::None) => {
                "one network's 5 comparators move values and indices, and serve the hit test; no accumulator"
            }
        },
        _ => "",
    }
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

fn new_table() -> Table {
    let mut table = Table::new();
    table.load_preset(presets::ASCII_MARKDOWN).set_content_arrangement(ContentArrangement::Dynamic);
    if table.width().is_none() {
        table.set_width(140);
    }
    table
}
