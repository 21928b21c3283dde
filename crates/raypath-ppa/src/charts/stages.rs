//! The stages of a design as bars of area and of delay.

use super::bars::{BAR, COLUMN, LEFT, LEGEND, Segment, axis, bar, colour, legend, scaled};
use crate::{Area, Path, Report};
use raypath_rtl::report::drawing::{self, text};
use raypath_tools::grouped;

const AREA_TOP: i32 = 84;
const AREA_HEIGHT: i32 = 320;
const TIME_TOP: i32 = 470;
const TIME_HEIGHT: i32 = 150;

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

/// A stage's area by kind, from the bottom.
fn kinds(area: &Area) -> Vec<Segment> {
    let units = area.units.iter().map(|(kind, units)| (kind.as_str(), units.area));
    let segment = |(name, size): (&str, f64)| Segment { name: name.to_string(), colour: colour(name), size };
    units.chain(area.other_kinds()).map(segment).filter(|segment| segment.size > 0.0).collect()
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
