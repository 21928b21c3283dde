//! The datapath in tables: schedule (Table VII), units (Table VIII) and registers, all computed from the netlist.

use crate::{
    Budget, Config, DatapathNetlist, EXCEPTIONS, Exception, Lanes, PRESETS, Preset, STAGES, StageNote, StepLabel,
    UnitKind, Units,
};
use comfy_table::presets::ASCII_MARKDOWN;
use comfy_table::{CellAlignment, ContentArrangement, Row, Table};
use raypath_ops::{JobKind, Rules};

/// Table VII: the work of each operation in each step.
pub fn schedule(datapath: &DatapathNetlist) -> String {
    let operations: Vec<&str> = datapath.schedule(1).iter().map(|note| note.operation).collect();
    let row = |(index, step): (usize, StepLabel)| {
        [step.to_string()].into_iter().chain(datapath.schedule(index).iter().map(cell)).collect::<Vec<_>>()
    };
    let rows = datapath.steps().enumerate().skip(1).map(row);
    table([&["stage"], operations.as_slice()].concat(), rows).to_string()
}

/// The work of one operation in each step, and the units of the step for all operations.
pub fn schedule_of(datapath: &DatapathNetlist, operation: &str) -> String {
    let row = |(index, step): (usize, StepLabel)| {
        let notes = datapath.schedule(index);
        let own = notes.iter().find(|note| note.operation == operation).map(cell).unwrap_or_default();
        [step.to_string(), own, list(datapath.units(index))]
    };
    let rows = datapath.steps().enumerate().skip(1).map(row);
    table(["stage", operation, "units that are there"], rows).to_string()
}

fn cell(note: &StageNote) -> String {
    let units = list(note.units);
    match (units.is_empty(), note.what.is_empty()) {
        (true, _) => note.what.clone(),
        (_, true) => units,
        _ => format!("{units}: {}", note.what),
    }
}

/// The units of each step and the registers after it. For the configurations of Table VIII, the units there, and the
/// reasons for differences.
pub fn units_and_registers(datapath: &DatapathNetlist, config: Config) -> String {
    let has_paper = is_in_table_viii(config);
    let row = |stage: &str, units: Units, paper: Units, live: u64, flip_flops: u64, why: &str| {
        let mut cells = vec![stage.to_string(), list(units), live.to_string(), flip_flops.to_string()];
        if has_paper {
            cells.insert(2, list(paper));
            cells.push(why.to_string());
        }
        cells
    };
    let mut header = vec!["stage", "units", "live bits", "flip-flops"];
    if has_paper {
        header.insert(2, "Table VIII");
        header.push("why the units differ");
    }
    let mut rows = Vec::new();
    let (mut all, mut live, mut flip_flops) = (Units::default(), 0, 0);
    for (index, step) in datapath.steps().enumerate() {
        let registers = datapath.registers(index);
        let units = datapath.units(index);
        all = all + units;
        live += registers.live;
        flip_flops += registers.flip_flops();
        let why = difference(datapath, config, index).join("; ");
        rows.push(row(&step.to_string(), units, paper_units(step), registers.live, registers.flip_flops(), &why));
    }
    let paper = (1..=STAGES).map(|stage| Budget::TABLE_VIII.units(stage)).sum();
    rows.push(row("all", all, paper, live, flip_flops, ""));
    table(header, rows).to_string()
}

/// Whether Table VIII has this configuration: 16 lanes or none, and units of one stage.
fn is_in_table_viii(config: Config) -> bool {
    matches!(config.semantics.lanes, Lanes::None | Lanes::Sixteen)
        && !config.microarchitecture.unit_latency.is_divided()
}

/// The configurations with names.
pub fn presets() -> String {
    let row = |preset: &Preset| [preset.name.to_string(), preset.config.options(), preset.purpose.to_string()];
    table(["preset", "what differs from the first", "what it is for"], PRESETS.iter().map(row)).to_string()
}

/// The values of parameters that cannot be combined.
pub fn exceptions() -> String {
    let row =
        |Exception { values, with, reason, .. }: &Exception| [values.to_string(), with.to_string(), reason.to_string()];
    table(["refused", "together with", "because"], EXCEPTIONS.iter().map(row)).to_string()
}

/// The reason why a step, by its index in [`DatapathNetlist::steps`], has other units than its stage in Table VIII; empty if
/// it has the same.
pub fn difference(datapath: &DatapathNetlist, config: Config, index: usize) -> Vec<&'static str> {
    let Some(step) = datapath.steps().nth(index) else { return Vec::new() };
    let (ours, paper) = (datapath.units(index), paper_units(step));
    let mut causes = Vec::new();
    if step.parts > 1 {
        causes.push("the stage takes several steps");
    }
    let is_paper = |name: &str| JobKind::ALL.iter().any(|kind| kind.name() == name);
    let schedule = datapath.schedule(index);
    let most = |of_paper: bool, kind| {
        let notes = schedule.iter().filter(|note| is_paper(note.operation) == of_paper);
        notes.map(|note| note.units.of(kind)).max().unwrap_or(0)
    };
    if UnitKind::ALL.into_iter().any(|kind| most(false, kind) > paper.of(kind).max(most(true, kind))) {
        causes.push("operations beside the paper's");
    }
    if ours.encode + ours.decode > 0 {
        causes.push("conversion, which Table VIII leaves out");
    }
    if ours.add != paper.add || ours.multiply != paper.multiply {
        match config.semantics.lanes {
            Lanes::None => causes.push("no distance modes"),
            Lanes::Sixteen => {}
            _ => causes.push("other lanes than the paper's 16"),
        }
    }
    if ours.compare != paper.compare {
        causes.extend(match (step.stage, config.semantics.rules) {
            (4, Rules::Paper | Rules::Bounds(_)) => &["ruling 1: the sign of inv is read, not compared"][..],
            (10, Rules::Paper | Rules::Bounds(_)) => {
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

fn paper_units(step: StepLabel) -> Units {
    Budget::TABLE_VIII.units(step.stage)
}

/// The units as text, `24 add, 4 compare`; empty if there are none.
pub fn list(units: Units) -> String {
    let named = UnitKind::ALL.into_iter().map(|kind| (units.of(kind), kind.stem()));
    let present: Vec<String> =
        named.filter(|(number, _)| *number > 0).map(|(number, stem)| format!("{number} {stem}")).collect();
    present.join(", ")
}

/// A table in the format of all tables: Markdown that fits the terminal.
pub fn table<R: Into<Row>>(head: impl Into<Row>, rows: impl IntoIterator<Item = R>) -> Table {
    let mut table = Table::new();
    table.load_preset(ASCII_MARKDOWN).set_content_arrangement(ContentArrangement::Dynamic);
    if table.width().is_none() {
        table.set_width(140);
    }
    table.set_header(head).add_rows(rows);
    table
}

/// The text of a table whose columns from `from` on are aligned to the right.
pub fn right_aligned(mut table: Table, from: usize) -> String {
    table.column_iter_mut().skip(from).for_each(|column| column.set_cell_alignment(CellAlignment::Right));
    table.to_string()
}
