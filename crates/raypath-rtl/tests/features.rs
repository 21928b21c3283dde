//! Features of the paper's operations, and of all operations.

mod exceptions;
mod options;

use crate::common::driver::Driver;
use raypath_ops::Concrete;
use raypath_rtl::{Config, DatapathNetlist};
use std::cell::Cell;

/// Compares random jobs of a configuration with its operations over a circuit, and with the exceptions in `raised`.
fn check(circuit: impl Concrete + 'static, config: Config, raised: Option<&'static Cell<u64>>, jobs: usize) {
    let mut driver = Driver::new(circuit, config);
    driver.raised = raised;
    let Ok(()) = config.semantics.operations(&mut driver);
    driver.run(&config.to_string(), &DatapathNetlist::new(config).expect("a datapath"), jobs);
}
