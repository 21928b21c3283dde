//! One mutant before the checks of the everyday tests.

use super::Fate;
use super::sample::{Elaborated, Subject};
use crate::check::{Everyday, Failed};
use crate::engine::NetlistEngine;
use crate::models::{Visitor, with_model};
use crate::verify::Error;
use raypath_hdl::Module;
use raypath_model::Model;
use std::sync::Arc;

/// A mutant.
pub struct Trial<'s> {
    pub subject: &'s Subject,
    /// The module with the fault.
    pub module: Arc<Module>,
    /// The datapath with that module.
    pub top: Arc<Module>,
}

impl Trial<'_> {
    /// The cheapest check first, until one fails.
    pub fn run(&self) -> Result<Fate, Error> {
        if let Some(unit) = &self.subject.unit
            && let Some(check) = unit.check(&self.module)?
        {
            return Ok(Fate::Killed(check));
        }
        let Elaborated { config, .. } = *self.subject.datapath;
        match with_model(config, Whole { datapath: &self.subject.datapath, top: &self.top })? {
            Err(failed) => Ok(Fate::Killed(failed.check)),
            Ok(()) => Ok(Fate::Survived("")),
        }
    }
}

/// The checks of a whole datapath.
struct Whole<'t> {
    datapath: &'t Elaborated,
    top: &'t Arc<Module>,
}

impl Visitor for Whole<'_> {
    type Answer = Result<Result<(), Failed>, Error>;

    fn visit<M: Model>(self, model: M) -> Self::Answer {
        let Elaborated { config, shape, .. } = self.datapath;
        let mut netlist = NetlistEngine::over(model.clone(), *config, shape.clone(), self.top, |_| false)?;
        Ok(Everyday { config: *config, seed: 1 }.check(&mut netlist, &model))
    }
}
