//! The candidates that wait for a verdict.

use super::connect::{Inputs, Named, keep, named};
use super::parameters::UnitParameters;
use super::queue::{bits, queue};
use crate::query::Front;
use crate::step::{StepParameters, UnitFeatures};
use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// What a candidate shows of the closest hit of its block: the name, the width, and whether a box has 0.
const TESTED: [(&str, u32, bool); 7] = [
    ("t", 32, true),
    ("primitive", 32, false),
    ("geometry", 32, false),
    ("t_num", 32, true),
    ("t_denom", 32, true),
    ("u_num", 32, true),
    ("v_num", 32, true),
];

/// What a candidate shows of the state of its ray: the field, and the name.
const STATE: [(&str, &str, u32); 5] = [
    ("leaf_is_box", "is_box", 1),
    ("leaf_is_opaque", "is_opaque", 1),
    ("instance_index", "instance", 32),
    ("instance_custom_index", "custom_index", 24),
    ("instance_shader_offset", "shader_offset", 24),
];

/// What says which face is the front: of the closest hit, and of the state.
const IS_CLOCKWISE: &str = "is_clockwise";
const IS_FLIPPED: &str = "instance_flags_flipped";

/// Whether a candidate shows this field of the closest hit (`tested`) or of the state (`next`), or what follows from it.
pub fn is_of_candidate(stem: &str, field: &str, features: UnitFeatures) -> bool {
    let is_known = match stem {
        "tested" => field == IS_CLOCKWISE || TESTED.iter().any(|(known, ..)| *known == field),
        _ => field == IS_FLIPPED || STATE.iter().any(|(known, ..)| *known == field),
    };
    is_known && features.has(field)
}

/// The module `raypath_unit_candidates`. The closest hit of a block, `tested_…_i`, is kept where `is_tested_i` is 1. If
/// it is a candidate, its ray asks where `asks_i` is 1 a cycle later, in the state `next_…_i`. Candidates leave in order:
/// `valid_o`, `tag_o`, which is the context, and `cand_…_o`, until `ready_i` is 1. Where `read_o` is 1, the id and
/// the numbers of the ray in `context_o` are read.
pub fn candidates(parameters: UnitParameters) -> Result<Arc<Module>, Error> {
    let UnitParameters { contexts, step: StepParameters { features, front, .. }, .. } = parameters;
    let builder = Builder::new("raypath_unit_candidates");
    let m = &builder;
    m.doc("The candidates that wait for a verdict, in the order in which their rays ask.");
    let width = bits(contexts);
    let is_tested = m.input("is_tested_i", 1);
    let tested_context = m.input("tested_context_i", width);
    let input = |stem: &str, field: &str, width: u32| named(field, m.input(&format!("{stem}_{field}_i"), width));
    let fields = TESTED.iter().map(|(field, width, _)| (*field, *width)).chain([(IS_CLOCKWISE, 1)]);
    let tested: Named<'_> = fields
        .filter(|(field, _)| is_of_candidate("tested", field, features))
        .map(|(field, width)| input("tested", field, width))
        .collect();
    let asks = m.input("asks_i", 1);
    let context = m.input("context_i", width);
    let fields = STATE.iter().map(|(field, _, width)| (*field, *width)).chain([(IS_FLIPPED, 1)]);
    let state: Named<'_> = fields
        .filter(|(field, _)| is_of_candidate("next", field, features))
        .map(|(field, width)| input("next", field, width))
        .collect();
    let ready = m.input("ready_i", 1);

    m.section("The contexts that ask, and the one at the port");
    let valid = m.register("valid_q", 1).reset_to(0);
    let takes = m.forward("takes", 1);
    let asked = Inputs::default().port("push", asks).port("context", context).port("pop", takes.wire()).place(
        m,
        "u_asked",
        &queue("raypath_unit_asked", contexts, &[("context", width)])?,
    );
    let first = asked.port("context");
    takes.drive(asked.port("valid") & (!valid.wire() | ready));
    let read = takes.wire();
    valid.next(read | (valid.wire() & !ready));
    let tag = m.register("tag_q", width);
    tag.next_when(read, first);

    m.section("What it shows: of a box the indices alone");
    let tested = keep("u_tested", contexts, (is_tested, tested_context), tested, (read, first));
    let state = keep("u_states", contexts, (asks, context), state, (read, first));
    let find = |words: &[(String, Wire<'_>)], field: &str| words.iter().position(|(name, _)| name == field);
    let is_box = find(&state, "leaf_is_box").map_or(valid.wire(), |place| state[place].1);
    let clockwise = find(&tested, IS_CLOCKWISE).map_or(is_box, |place| tested[place].1);
    let back_face = match front {
        Front::CounterClockwise => clockwise,
        Front::Clockwise => !clockwise,
    };
    let back_face = find(&state, IS_FLIPPED).map_or(back_face, |place| back_face ^ state[place].1) & !is_box;

    m.output("read_o", read);
    m.output("context_o", first);
    m.output("valid_o", valid.wire());
    m.output("tag_o", tag.wire());
    for (field, name, _) in STATE {
        if let Some(place) = find(&state, field) {
            m.output(&format!("cand_{name}_o"), state[place].1);
        }
    }
    for (field, width, is_of_triangle) in TESTED {
        if let Some(place) = find(&tested, field) {
            let word = tested[place].1;
            let shown = if is_of_triangle { word & (!is_box).replicate(width) } else { word };
            m.output(&format!("cand_{field}_o"), shown);
        }
    }
    m.output("cand_back_face_o", back_face);
    builder.finish()
}
