//! Area and timing, shown: what `raypath-ppa` measured as tables and pictures, beside earlier figures, and over many
//! configurations.

mod earlier;
mod exploration;
mod scatter;
mod stages;
mod tables;

pub use earlier::Earlier;
pub use exploration::{Exploration, Point};
pub use raypath_ppa::*;
pub use scatter::scatter;
pub use stages::stages;
pub use tables::{areas, comparison, explored, paths, summary, units};
