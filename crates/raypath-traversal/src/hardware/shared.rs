//! How searches and rays share the datapath.

use super::connect::{Named, Outputs, named};
use super::jobs::box_word;
use super::queue::bits;
use crate::search::SEPARATORS;
use raypath_hdl::{Builder, Wire};
use raypath_ops::operations::key_compare::KeyCompareInput;
use raypath_ops::operations::point_in_box::PointInBoxInput;
use raypath_ops::{Binary32, ports_of};

/// Whether a beat is next, and not the job of a ray, if one or both are offered: so many beats, and then a job of a ray,
/// if both wait.
pub fn whose_turn<'m>(m: &'m Builder, turns: u32, [ray, beat]: [Wire<'m>; 2], takes: Wire<'m>) -> Wire<'m> {
    let before = m.register("beats_before_q", bits(turns + 1)).reset_to(0);
    before.wire().comment("the beats that went before the job of a ray that waits");
    let is_turn_of_ray = before.wire().is(turns.into());
    let is_beat = (beat & !(ray & is_turn_of_ray)).named("is_beat_next");
    let one_more = before.wire() + m.constant(before.wire().width(), 1);
    let after = (is_beat & ray).mux(one_more, m.constant(before.wire().width(), 0));
    before.next_when(takes & (ray | beat), after);
    is_beat
}

/// The inputs of the datapath that nodes of trees have. Those that rays have too are shared.
pub fn node_inputs<'m>(engine: &Outputs<'m>, is_beat: Wire<'m>, inputs: &mut Named<'m>) {
    let m = is_beat.builder();
    let query = |k: usize| engine.port(&format!("beat_a_{k}"));
    // The second block of a node is that of a vector of binary32.
    let word = |k: usize| {
        if k < 16 { engine.port(&format!("beat_node_{k}")) } else { engine.port(&format!("beat_b_{}", k - 16)) }
    };
    let separator = |k| if k < SEPARATORS { word(k) } else { m.constant(32, f32::NAN.to_bits().into()) };
    let of_keys = [query(3)].into_iter().chain((0..).map(separator));
    let of_boxes = (0..3).map(query).chain((0..).map(|k| word(box_word(k))));
    let keys = ports_of::<KeyCompareInput<Binary32>>().into_iter().zip(of_keys);
    for (port, wire) in keys.chain(ports_of::<PointInBoxInput<Binary32>>().into_iter().zip(of_boxes)) {
        match inputs.iter_mut().find(|(known, _)| *known == port.name) {
            Some((_, of_ray)) => *of_ray = is_beat.mux(wire, *of_ray),
            None => inputs.push((port.name, wire)),
        }
    }
}

/// The inputs of the datapath that beats have.
pub fn beat_inputs<'m>(engine: &Outputs<'m>) -> Named<'m> {
    let lanes = engine.under("beat_mask").len();
    let mask: Vec<Wire<'m>> = (0..lanes).rev().map(|lane| engine.port(&format!("beat_mask_{lane}"))).collect();
    let mut inputs = Vec::new();
    for stem in ["a", "b"] {
        let lane =
            |lane: usize| named(&format!("euclidean_{stem}_{lane}"), engine.port(&format!("beat_{stem}_{lane}")));
        inputs.extend((0..lanes).map(lane));
    }
    inputs.push(named("euclidean_mask", mask[0].builder().concat(&mask)));
    inputs.push(named("euclidean_reset_accum", engine.port("beat_is_last")));
    inputs
}
