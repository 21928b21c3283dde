//! Tests of the units' netlists, in our simulator and in Verilator, against oracles that share no code with them.

mod binary32;
mod division;
mod exact;
mod narrow;
mod other_formats;
mod small_formats;
mod sums;
mod verilator;
mod words;

use raypath_float::Format;
use raypath_hdl::{Error, Module};
use raypath_verify_arithmetic::units::bench::{Bench, PortFormat, Simulated, Units};
use std::sync::Arc;

/// The units of a format in simulation.
fn bench(format: Format, ports: PortFormat) -> Bench {
    Units::new(format).and_then(|units| Bench::new(&units, ports)).expect("the bench runs")
}

/// A converter in simulation.
fn converter(unit: Result<Arc<Module>, Error>) -> Simulated {
    unit.and_then(|unit| Simulated::new(&unit)).expect("the converter runs")
}
