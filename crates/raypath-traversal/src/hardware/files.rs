//! The files of the unit.

use super::top::UnitNetlist;
use crate::error::UnitError;
use raypath_rtl::package::{self, Wrapped};
use std::path::PathBuf;

/// What the unit is, for manifests.
const PURPOSE: &str = "A ray-tracer traversal unit";

impl UnitNetlist {
    /// The parameters of the unit and of its datapath in words.
    pub fn description(&self) -> String {
        format!("traversal unit, {}; datapath: {}", self.parameters, self.config)
    }

    /// All files of the unit, each with its path in the output folder ([`package::wrapped`]). The wrappers are
    /// `raypath_unit_axi`, whose constraints are for a clock of `period_ns`, `raypath_unit_wrapper`, and
    /// `raypath_device`.
    ///
    /// # Errors
    /// A defect of the netlist.
    pub fn files(&self, period_ns: f64) -> Result<Vec<(PathBuf, String)>, UnitError> {
        let top = &self.emitted()?;
        Ok(package::wrapped(Wrapped {
            top,
            wrapper: &self.axi_of(top)?,
            beyond: &self.device()?,
            properties: &self.properties(),
            types: &[("cand", "candidate")],
            purpose: PURPOSE,
            description: &self.description(),
            period_ns,
        })?)
    }
}
