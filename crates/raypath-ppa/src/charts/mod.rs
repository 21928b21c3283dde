//! Measurements as pictures in SVG.

mod axes;
mod bars;
mod power;
mod scatter;
mod stages;

pub use power::power;
pub use scatter::scatter;
pub use stages::stages;
