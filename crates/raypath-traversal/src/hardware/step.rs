//! A step in hardware: two modules without registers, and the pipeline around them.

use super::package::refer_to_package;
use crate::blocks::wide8::{Half, window};
use crate::netlist::{Netlist, Value, inputs, inputs_with, outputs, outputs_with};
use crate::state::{Answer, Group, RayState};
use crate::step::{HalfStep, StepParameters, finish, prepare};
use raypath_hdl::{Builder, Error, Module};
use raypath_ops::Word;
use std::sync::Arc;

/// The module `raypath_unit_prepare`: the first half of a step, without registers. Its inputs are `state_…_i` and
/// `answer_…_i`, its outputs `half_…_o`, with the fields of [`RayState`], [`Answer`] and [`HalfStep`].
///
/// # Errors
/// A defect of the description.
pub fn prepare_module(parameters: StepParameters) -> Result<Arc<Module>, Error> {
    let m = Builder::new("raypath_unit_prepare");
    m.doc("What happens to a ray when an answer arrives, before its stack is read.");
    m.doc(
        "A ray whose stack has lost the deepest pending level descends again from the root, along the places of the \
           children that it took (a restart trail), and takes the next child at that level.",
    );
    refer_to_package(&m, parameters.features);
    let state: RayState<Netlist<'_>> = inputs_with(&m, "state", parameters);
    let answer: Answer<Netlist<'_>> = inputs_with(&m, "answer", parameters);
    let node_limit = Word::new(Netlist(&m), Value(m.input("node_limit_i", 32)));
    outputs_with(&m, "half", &prepare(Netlist(&m), parameters, state, answer, node_limit), parameters);
    m.finish()
}

/// The module `raypath_unit_window`: which children of eight a step takes, without registers. Its inputs are
/// `lower_…_i` and `upper_…_i`, with the fields of [`Half`], and `window_i`; its outputs `window_…_o`, with those of
/// [`Window`](crate::blocks::wide8::Window).
///
/// # Errors
/// A defect of the description.
pub fn window_module() -> Result<Arc<Module>, Error> {
    let m = Builder::new("raypath_unit_window");
    m.doc("The children of a node with eight that a step takes, near to far, from the outcomes of its two jobs.");
    let [lower, upper]: [Half<Netlist<'_>>; 2] = ["lower", "upper"].map(|name| inputs(&m, name));
    let c = Netlist(&m);
    outputs(&m, "window", &window(c, [lower, upper], Word::new(c, Value(m.input("window_i", 2)))));
    m.finish()
}

/// The module `raypath_unit_finish`: the second half of a step, without registers. Its inputs are `half_…_i` and
/// `top_…_i`, its outputs `next_…_o` and `request_…_o`, with the fields of [`HalfStep`], [`Group`], [`RayState`] and
/// [`Request`](crate::state::Request).
///
/// # Errors
/// A defect of the description.
pub fn finish_module(parameters: StepParameters) -> Result<Arc<Module>, Error> {
    let m = Builder::new("raypath_unit_finish");
    m.doc("What happens to a ray when an answer arrives, after its stack is read.");
    refer_to_package(&m, parameters.features);
    m.doc(format!("The stack of a ray has {} entries.", parameters.stack));
    m.doc("The entry of a level is at the level modulo their number, so that deep levels overwrite high ones: base is the \
           lowest level that is not overwritten.");
    let half: HalfStep<Netlist<'_>> = inputs_with(&m, "half", parameters);
    let top: Group<Netlist<'_>> = inputs(&m, "top");
    let (next, request) = finish(Netlist(&m), parameters, half, top);
    outputs_with(&m, "next", &next, parameters);
    outputs_with(&m, "request", &request, parameters);
    m.finish()
}
