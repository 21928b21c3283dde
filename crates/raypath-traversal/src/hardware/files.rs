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
    /// `raypath_device`. A unit with searches has `raypath_unit_wrapper` alone.
    ///
    /// # Errors
    /// A defect of the netlist.
    pub fn files(&self, period_ns: f64) -> Result<Vec<(PathBuf, String)>, UnitError> {
        let top = &self.emitted()?;
        // The memory ports of the others are those of rays.
        let has_searches = self.parameters.search.0.is_some();
        let axi = if has_searches { None } else { Some(self.axi_of(top)?) };
        let beyond = if has_searches { Vec::new() } else { self.device()? };
        Ok(package::wrapped(Wrapped {
            top,
            wrapper: axi.as_ref(),
            beyond: &beyond,
            properties: &self.properties(),
            types: &[("cand", "candidate")],
            purpose: PURPOSE,
            description: &self.description(),
            period_ns,
        })?)
    }
}
