//! Measurements as pictures in SVG.

mod scatter;
mod stages;

pub use scatter::scatter;
pub use stages::stages;

/// The smallest of 1, 2, 5, 10, 20 ... that is not less than `min`: the step between the marks of an axis.
fn round_step(min: f64) -> f64 {
    let power = 10_f64.powf(min.max(1e-9).log10().floor());
    [1.0, 2.0, 5.0].map(|digit| digit * power).into_iter().find(|step| *step >= min).unwrap_or(10.0 * power)
}
