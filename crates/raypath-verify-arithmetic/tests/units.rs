//! Tests of the units' netlists, in our simulator and in Verilator, against oracles that share no code with them.

mod conversions;
mod division;
mod linters;
mod narrow;
mod short;
mod sums;

use raypath_hdl::{Error, Module, Simulator};
use std::sync::Arc;

/// A converter in simulation.
fn converter(unit: Result<Arc<Module>, Error>) -> Simulator {
    unit.and_then(|unit| Simulator::new(&unit)).expect("the converter runs")
}
