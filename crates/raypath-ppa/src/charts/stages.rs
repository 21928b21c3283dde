//! The stages of a design as bars of area and of delay.

use super::{grid, marks};
use crate::{Area, Path, Report};
use raypath_rtl::report::drawing::{self, line, rectangle, text};
use raypath_tools::grouped;
use svg::node::element::{Group, Title};

const LEFT: i32 = 64;
const COLUMN: i32 = 66;
const BAR: i32 = 44;
const AREA_TOP: i32 = 84;
const AREA_HEIGHT: i32 = 320;
const TIME_TOP: i32 = 470;
const TIME_HEIGHT: i32 = 150;
const LEGEND: i32 = 150;

/// The colours of the segments of a path: the register at its start, gates, units, set-up time.
const REGISTER: &str = "#555555";
const GATES: &str = "#999999";
const UNIT: &str = "#0072b2";
const SETUP: &str = "#000000";

/// A report as SVG: for each stage a stacked bar of area by kind, and below it one of its slowest path by element.
pub fn stages(report: &Report) -> String {
    let columns = report.stages.len() as i32;
    let right = LEFT + columns * COLUMN;
    let (width, height) = (right + LEGEND, TIME_TOP + TIME_HEIGHT + 48);
    let max_area = report.stages.iter().map(|stage| stage.area.total).fold(1.0, f64::max);
    let max_time = report.slowest.ns.max(0.01);
    let summary = format!(
        "{:.3} mm² = {:.1} kGE, {} flip-flops; slowest path {:.2} ns = {:.1} MHz; library {}",
        report.area.total / 1e6,
        report.kilo_gates,
        grouped(report.flip_flops),
        report.slowest.ns,
        report.clock_mhz,
        report.setting.library
    );
    let mut picture = drawing::picture("Area and slowest path by stage", width, height)
        .add(text(12, 24, "head", &format!("raypath: {}", report.design)))
        .add(text(12, 42, "small", &summary))
        .add(text(12, AREA_TOP - 14, "small", "area, thousands of µm²"))
        .add(text(12, TIME_TOP - 18, "small", "slowest path that ends in the stage, ns"))
        .add(axis(AREA_TOP, AREA_HEIGHT, right, max_area / 1000.0))
        .add(axis(TIME_TOP, TIME_HEIGHT, right, max_time));
    for (column, stage) in report.stages.iter().enumerate() {
        let x = LEFT + column as i32 * COLUMN + (COLUMN - BAR) / 2;
        let middle = x + BAR / 2;
        let area = bar(x, AREA_TOP + AREA_HEIGHT, AREA_HEIGHT, max_area, &kinds(&stage.area));
        let total = format!("{:.0}", stage.area.total / 1000.0);
        let top = AREA_TOP + AREA_HEIGHT - scaled(stage.area.total, max_area, AREA_HEIGHT);
        picture = picture.add(area).add(text(middle, top - 4, "small middle", &total)).add(text(
            middle,
            AREA_TOP + AREA_HEIGHT + 16,
            "middle",
            stage.name.trim_start_matches("stage "),
        ));
        if let Some(path) = &stage.slowest {
            let top = TIME_TOP + TIME_HEIGHT - scaled(path.ns, max_time, TIME_HEIGHT);
            picture = picture
                .add(bar(x, TIME_TOP + TIME_HEIGHT, TIME_HEIGHT, max_time, &delays(path)))
                .add(text(middle, top - 4, "small middle", &format!("{:.2}", path.ns)))
                .add(text(middle, TIME_TOP + TIME_HEIGHT + 16, "middle", stage.name.trim_start_matches("stage ")));
        }
    }
    let present = kinds(&report.area).into_iter().map(|segment| (segment.name, segment.colour));
    let times = [("register", REGISTER), ("gates", GATES), ("unit", UNIT), ("set-up", SETUP)];
    let times = times.map(|(name, colour)| (name.to_string(), colour)).into_iter();
    picture = picture.add(legend(right + 20, AREA_TOP, present)).add(legend(right + 20, TIME_TOP, times));
    picture.to_string() + "\n"
}

/// A segment of a stacked bar.
struct Segment {
    name: String,
    colour: &'static str,
    size: f64,
}

/// A stage's area by kind, from the bottom, in colours that colour-blind readers distinguish (Okabe and Ito).
fn kinds(area: &Area) -> Vec<Segment> {
    let unit = |kind: &str| match kind.split(' ').next() {
        Some("mul") => "#0072b2",
        Some("add") => "#d55e00",
        Some("compare") => "#009e73",
        Some("encode") => "#cc79a7",
        _ => "#e69f00",
    };
    let units =
        area.units.iter().map(|(kind, units)| Segment { name: kind.clone(), colour: unit(kind), size: units.area });
    let colours = ["#555555", "#56b4e9", "#999999", "#f0e442", "#c8c8c8", "#000000"];
    let others = area.other_kinds().into_iter().zip(colours);
    let others = others.map(|((name, size), colour)| Segment { name: name.to_string(), colour, size });
    units.chain(others).filter(|segment| segment.size > 0.0).collect()
}

/// A path's delay by element, from the bottom.
fn delays(path: &Path) -> Vec<Segment> {
    let mut before = 0.0;
    let mut segments = Vec::new();
    for (number, step) in path.steps.iter().enumerate() {
        let colour = match step.through.as_str() {
            _ if number == 0 => REGISTER,
            "gates" => GATES,
            unit if unit.starts_with("u_") => UNIT,
            _ => GATES,
        };
        segments.push(Segment { name: step.through.clone(), colour, size: step.ns - before });
        before = step.ns;
    }
    segments.push(Segment { name: "set-up".to_string(), colour: SETUP, size: path.setup_ns });
    segments
}

fn bar(x: i32, bottom: i32, height: i32, max: f64, segments: &[Segment]) -> Group {
    let mut reached = 0.0;
    let mut group = Group::new();
    for segment in segments {
        // Edges, not heights, are rounded, so that errors do not add up.
        let (low, high) = (scaled(reached, max, height), scaled(reached + segment.size, max, height));
        reached += segment.size;
        if high > low {
            let title = Title::new(format!("{}: {:.2}", segment.name, segment.size));
            group = group.add(rectangle(x, bottom - high, BAR, high - low, segment.colour).add(title));
        }
    }
    group
}

/// Horizontal grid lines at round numbers.
fn axis(top: i32, height: i32, right: i32, max: f64) -> Group {
    let group = Group::new().add(line((LEFT, top + height), (right, top + height), "#222222"));
    grid(group, LEFT, right, marks(max / 4.0, max), |value| top + height - scaled(value, max, height))
}

fn legend(x: i32, top: i32, entries: impl Iterator<Item = (String, &'static str)>) -> Group {
    let entry = |(number, (name, colour)): (usize, (String, &str))| {
        let y = top + 18 * number as i32;
        Group::new().add(rectangle(x, y, 12, 12, colour)).add(text(x + 18, y + 10, "small", &name))
    };
    entries.enumerate().map(entry).fold(Group::new(), Group::add)
}

fn scaled(value: f64, max: f64, height: i32) -> i32 {
    (value / max * f64::from(height)).round() as i32
}
