//! Configurations as points of area against throughput.

use super::axes::{grid, marks, shown};
use crate::{DesignPoint, Exploration};
use raypath_rtl::report::drawing::{self, line, text};
use svg::node::element::{Circle, Group, Title};

const PANEL: i32 = 470;
const HEIGHT: i32 = 380;
const LEFT: i32 = 64;
const TOP: i32 = 84;
const BETWEEN: i32 = 210;

/// An exploration as SVG, in two panels: area against the clock, which is also jobs per second; and area against
/// dimensions of distances per second, for configurations with distance modes. A dashed line in each marks the least
/// area per throughput of all points.
pub fn scatter(exploration: &Exploration) -> String {
    let width = LEFT + 2 * (PANEL + BETWEEN);
    let max_area = exploration.points.iter().map(area).fold(0.1, f64::max) * 1.1;
    let title = "Area against clock and throughput";
    let setting = exploration.points.first().map(|point| &point.report.setting);
    let setting =
        setting.map(|setting| format!("{}, {}, library {}", setting.synthesis, setting.timing, setting.library));
    let dimensions = |point: &DesignPoint| point.dimensions_per_second / 1e9;
    drawing::picture(title, width, TOP + HEIGHT + 56)
        .add(text(12, 24, "head", title))
        .add(text(12, 42, "small", &setting.unwrap_or_default()))
        .add(panel(exploration, LEFT, max_area, "million jobs a second = clock in MHz", |point| point.report.clock_mhz))
        .add(panel(exploration, LEFT + PANEL + BETWEEN, max_area, "thousand million dimensions a second", dimensions))
        .to_string()
        + "\n"
}

/// A diagram of area in mm² against `throughput`. Points without throughput are left out. `words` label the x axis.
fn panel(
    exploration: &Exploration,
    left: i32,
    max_area: f64,
    words: &str,
    throughput: impl Fn(&DesignPoint) -> f64,
) -> Group {
    let points: Vec<(&DesignPoint, f64)> = exploration.points.iter().map(|point| (point, throughput(point))).collect();
    let points: Vec<(&DesignPoint, f64)> = points.into_iter().filter(|(_, throughput)| *throughput > 0.0).collect();
    let max = points.iter().map(|(_, throughput)| *throughput).fold(0.0, f64::max) * 1.1;
    if max == 0.0 {
        return Group::new();
    }
    let x = |value: f64| left + (value / max * f64::from(PANEL)).round() as i32;
    let y = |value: f64| TOP + HEIGHT - (value / max_area * f64::from(HEIGHT)).round() as i32;
    let bottom = TOP + HEIGHT;
    let mut group = Group::new()
        .add(line((left, bottom), (left + PANEL, bottom), "#222222"))
        .add(line((left, TOP), (left, bottom), "#222222"))
        .add(text(left, TOP - 14, "small", "mm²"))
        .add(text(left + PANEL / 2, bottom + 40, "small middle", words));
    for value in marks(max / 6.0, max) {
        group = group.add(line((x(value), bottom), (x(value), bottom + 4), "#222222")).add(text(
            x(value),
            bottom + 18,
            "small middle",
            &shown(value),
        ));
    }
    group = grid(group, left, left + PANEL, marks(max_area / 6.0, max_area), y);
    // Equal area per throughput is a line through the origin.
    let best = points.iter().map(|(point, throughput)| area(point) / throughput).fold(f64::INFINITY, f64::min);
    let end = (max_area / best).min(max);
    group = group.add(line((x(0.0), y(0.0)), (x(end), y(end * best)), "#0072b2").set("stroke-dasharray", "4 4"));
    for (point, throughput) in &points {
        let colour = if area(point) / throughput <= best { "#0072b2" } else { "#d55e00" };
        let report = &point.report;
        let title = format!(
            "{}: {:.3} mm², {:.2} ns, {} flip-flops, {:.2} mm² ns",
            point.name,
            area(point),
            report.slowest.ns,
            report.flip_flops,
            report.area_period
        );
        let circle = Circle::new().set("cx", x(*throughput)).set("cy", y(area(point))).set("r", 5).set("fill", colour);
        group = group.add(circle.add(Title::new(title)));
    }
    let mut names: Vec<(i32, i32, &str)> =
        points.iter().map(|(point, throughput)| (y(area(point)), x(*throughput), point.name.as_str())).collect();
    names.sort_unstable();
    group.add(labels(&names, left + PANEL + 14))
}

/// Names in a column, each with a line to its point; `names` are `(y, x, name)` from the top.
fn labels(names: &[(i32, i32, &str)], column: i32) -> Group {
    let apart = (HEIGHT / names.len().max(1) as i32).min(15);
    let mut free = TOP;
    let mut group = Group::new();
    for (below, (y, x, name)) in names.iter().enumerate().map(|(index, name)| (names.len() - 1 - index, name)) {
        // As near to its point's height as the names above and below allow.
        let at = (*y).min(TOP + HEIGHT - below as i32 * apart).max(free);
        free = at + apart;
        group = group.add(line((*x, *y), (column - 3, at), "#bbbbbb")).add(text(column, at + 4, "small", name));
    }
    group
}

fn area(point: &DesignPoint) -> f64 {
    point.report.area.total / 1e6
}
