//! Tests of the units' netlists, in our simulator and in Verilator, against oracles that share no code with them.

mod conversions;
mod division;
mod linters;
mod narrow;
mod short;
mod sums;

use raypath_hdl::{Error, Module};
use raypath_verify_arithmetic::units::bench::Simulated;
use std::sync::Arc;

/// A converter in simulation.
fn converter(unit: Result<Arc<Module>, Error>) -> Simulated {
    unit.and_then(|unit| Simulated::new(&unit)).expect("the converter runs")
}
