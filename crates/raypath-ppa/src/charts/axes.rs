//! Axes: round marks, and lines with labels.

use raypath_rtl::report::drawing::{line, text};
use svg::node::element::Group;

/// Adds a horizontal line with a label for each value; `y` is the height of a value.
pub(super) fn grid(mut group: Group, left: i32, right: i32, values: Vec<f64>, y: impl Fn(f64) -> i32) -> Group {
    for value in values {
        let label = text(left - 6, y(value) + 4, "small right", &shown(value));
        group = group.add(line((left, y(value)), (right, y(value)), "#dddddd")).add(label);
    }
    group
}

/// The multiples up to `max` of a round number that is not less than `min_step`.
pub(super) fn marks(min_step: f64, max: f64) -> Vec<f64> {
    let step = round_step(min_step);
    (1..).map(|number| f64::from(number) * step).take_while(|value| *value <= max).collect()
}

/// A number rounded to six decimals, without trailing zeros.
pub(super) fn shown(value: f64) -> String {
    ((value * 1e6).round() / 1e6).to_string()
}

/// The smallest of 1, 2, 5, 10, 20 ... that is not less than `min`: the step between the marks of an axis.
fn round_step(min: f64) -> f64 {
    let power = 10_f64.powf(min.max(1e-9).log10().floor());
    [1.0, 2.0, 5.0].map(|digit| digit * power).into_iter().find(|step| *step >= min).unwrap_or(10.0 * power)
}
