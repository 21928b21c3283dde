//! The modules of the unit.

use crate::netlist::{Inputs, Netlist, Outputs};
use crate::state::{Answer, RayState};
use crate::step::{StepParameters, step};
use raypath_hdl::{Builder, Error, Module};
use std::sync::Arc;

/// The module `raypath_unit_step`: a step of a ray, without registers. Its inputs are `state_…_i` and `answer_…_i`, its
/// outputs `next_…_o` and `request_…_o`, with the fields of [`RayState`], [`Answer`] and
/// [`Request`](crate::state::Request).
///
/// # Errors
/// A defect of the description.
pub fn step_module(parameters: StepParameters) -> Result<Arc<Module>, Error> {
    let m = Builder::new("raypath_unit_step");
    m.doc("What happens to a ray when an answer arrives.");
    m.doc(format!("The stack of a ray has {} entries.", parameters.stack));
    let state: RayState<Netlist<'_>> = Inputs::bundle(&m, "state");
    let answer: Answer<Netlist<'_>> = Inputs::bundle(&m, "answer");
    let (next, request) = step(Netlist(&m), parameters, state, answer);
    Outputs::bundle(&m, "next", &next);
    Outputs::bundle(&m, "request", &request);
    m.finish()
}
