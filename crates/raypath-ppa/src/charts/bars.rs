//! Diagrams of stacked bars.

use super::axes::{grid, marks};
use raypath_rtl::report::drawing::{line, rectangle, text};
use svg::node::element::{Group, Title};

/// The left edge of a diagram, and the widths of a column, a bar and the legend.
pub(super) const LEFT: i32 = 64;
pub(super) const COLUMN: i32 = 66;
pub(super) const BAR: i32 = 44;
pub(super) const LEGEND: i32 = 150;

/// A segment of a stacked bar.
pub(super) struct Segment {
    pub name: String,
    pub colour: &'static str,
    pub size: f64,
}

/// The colour of a kind: colours that colour-blind readers distinguish (Okabe and Ito).
pub(super) fn colour(kind: &str) -> &'static str {
    match kind.split(' ').next() {
        Some("mul") => "#0072b2",
        Some("add") => "#d55e00",
        Some("compare") => "#009e73",
        Some("encode") => "#cc79a7",
        Some("registers") => "#555555",
        Some("operand") => "#56b4e9",
        Some("register") => "#999999",
        Some("shared") => "#f0e442",
        Some("output") => "#c8c8c8",
        Some("clock") => "#882255",
        Some("control") => "#000000",
        _ => "#e69f00",
    }
}

/// A bar of segments from the bottom upwards; one of the size `max` has this height.
pub(super) fn bar(x: i32, bottom: i32, height: i32, max: f64, segments: &[Segment]) -> Group {
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
pub(super) fn axis(top: i32, height: i32, right: i32, max: f64) -> Group {
    let group = Group::new().add(line((LEFT, top + height), (right, top + height), "#222222"));
    grid(group, LEFT, right, marks(max / 4.0, max), |value| top + height - scaled(value, max, height))
}

pub(super) fn legend(x: i32, top: i32, entries: impl Iterator<Item = (String, &'static str)>) -> Group {
    let entry = |(number, (name, colour)): (usize, (String, &str))| {
        let y = top + 18 * number as i32;
        Group::new().add(rectangle(x, y, 12, 12, colour)).add(text(x + 18, y + 10, "small", &name))
    };
    entries.enumerate().map(entry).fold(Group::new(), Group::add)
}

pub(super) fn scaled(value: f64, max: f64, height: i32) -> i32 {
    (value / max * f64::from(height)).round() as i32
}
