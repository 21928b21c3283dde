//! The pipeline as a picture, drawn from the schedule.

use crate::report::drawing::{self, rectangle, text};
use crate::report::tables::list;
use crate::{Config, Control, DatapathNetlist, StageNote};
use svg::node::element::{Group, Title};

const LEFT: i32 = 96;
const COLUMN: i32 = 88;
const HEAD: i32 = 64;
const ROW: i32 = 46;
const GAP: i32 = 6;
/// The colour of each operation (the palette of Okabe and Ito, distinct for colour-blind readers), and the class of
/// text on it.
const COLOURS: [(&str, &str); 8] = [
    ("#0072b2", "small on"),
    ("#d55e00", "small on"),
    ("#009e73", "small on"),
    ("#cc79a7", "small on"),
    ("#e69f00", "small"),
    ("#56b4e9", "small"),
    ("#f0e442", "small"),
    ("#000000", "small on"),
];

/// The pipeline of a datapath as SVG: a column for each stage with its registers, a row for each operation with its
/// units, the shared units, and the bits that cross each boundary.
pub fn pipeline(datapath: &DatapathNetlist, config: Config) -> String {
    let columns = datapath.latency() as i32;
    let operations = datapath.schedule(1);
    let rows = operations.len() as i32;
    let width = LEFT + columns * COLUMN + 16;
    let units_at = HEAD + rows * (ROW + GAP);
    let bits_at = units_at + ROW + 2 * GAP;
    let height = bits_at + 96;

    let mut picture = drawing::picture("The raypath pipeline", width, height)
        .add(text(12, 24, "head", &format!("raypath: {}", config)))
        .add(text(12, 42, "small", &caption(datapath, config)));
    for (row, operation) in operations.iter().enumerate() {
        let y = HEAD + row as i32 * (ROW + GAP);
        picture = picture.add(text(12, y + ROW / 2 + 4, "head", operation.operation));
    }
    picture =
        picture.add(text(12, units_at + ROW / 2 + 4, "head", "units")).add(text(12, bits_at + 16, "head", "bits"));
    let live = |index| datapath.registers(index).live;
    let most = (0..datapath.latency() as usize).map(live).max().unwrap_or(1).max(1);
    for (index, step) in datapath.steps().enumerate() {
        let x = LEFT + index as i32 * COLUMN;
        let title = if index == 0 { step.to_string() } else { format!("stage {step}") };
        picture = picture.add(text(x + 4, HEAD - 6, "head", &title)).add(buffer(
            x,
            units_at + ROW,
            config.microarchitecture.control,
        ));
        for (row, note) in datapath.schedule(index).iter().enumerate() {
            let y = HEAD + row as i32 * (ROW + GAP);
            picture = picture.add(cell(x, y, note, index, COLOURS[row % COLOURS.len()]));
        }
        let units = list(datapath.units(index));
        picture = picture.add(lines(x + 4, units_at + 14, "small", &units));
        let live = live(index);
        let length = (live * 64 / most) as i32;
        picture = picture.add(rectangle(x + COLUMN - 24, bits_at, 18, length.max(1), "#999999")).add(text(
            x + COLUMN - 52,
            bits_at + 12,
            "small",
            &live.to_string(),
        ));
    }
    picture.to_string() + "\n"
}

fn caption(datapath: &DatapathNetlist, config: Config) -> String {
    let bars = match config.microarchitecture.control {
        Control::Skid => "each bar between stages is a skid buffer",
        Control::Credit => "each bar between stages is a register that never stalls",
    };
    format!("one job a cycle, latency {}; {bars}", datapath.latency())
}

/// The work of an operation in a stage: its units on its colour, or a thin line if values only pass through.
fn cell(x: i32, y: i32, note: &StageNote, step: usize, (colour, class): (&str, &str)) -> Group {
    let units = list(note.units);
    let works = step > 0 && (!units.is_empty() || !note.what.is_empty());
    if !works {
        return Group::new().add(rectangle(x, y + ROW / 2 - 1, COLUMN - 14, 2, colour));
    }
    let shown = if units.is_empty() { "select".to_string() } else { units };
    Group::new().add(Title::new(note.what.clone())).add(rectangle(x, y, COLUMN - 14, ROW, colour)).add(lines(
        x + 6,
        y + 18,
        class,
        &shown,
    ))
}

/// The registers after a stage.
fn buffer(x: i32, bottom: i32, control: Control) -> Group {
    let (right, height) = (x + COLUMN - 12, bottom - HEAD);
    let front = Group::new().add(rectangle(right, HEAD, 3, height, "#555555"));
    match control {
        Control::Skid => front.add(rectangle(right + 5, HEAD, 3, height, "#aaaaaa")),
        Control::Credit => front,
    }
}

/// Comma-separated parts below each other.
fn lines(x: i32, y: i32, class: &str, parts: &str) -> Group {
    let below = |(line, part)| text(x, y + 14 * line as i32, class, part);
    parts.split(", ").enumerate().map(below).fold(Group::new(), Group::add)
}
