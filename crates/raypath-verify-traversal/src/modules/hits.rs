//! The hits of rays that have ended, with the host's division of weights.

use super::{Bench, CYCLES, number};
use rand::RngExt;
use raypath_traversal::{Queries, UnitParameters};
use std::collections::VecDeque;

/// The status of a ray that hits a triangle, and of one that hits a box.
const HIT: u64 = 1;
const BOX: u64 = 2;

/// A port out of a hit, the port in that it comes from, and whether it is 0 for a ray without a hit.
const VALUES: [(&str, &str, bool); 12] = [
    ("status_o", "status_i", false),
    ("t_o", "next_extent_i", true),
    ("primitive_o", "next_primitive_i", true),
    ("t_num_o", "next_t_num_i", true),
    ("t_denom_o", "next_t_denom_i", true),
    ("back_face_o", "next_back_face_i", true),
    ("nodes_o", "next_nodes_i", false),
    ("triangles_o", "next_triangles_i", false),
    ("instance_o", "next_hit_instance_index_i", true),
    ("geometry_o", "next_geometry_i", true),
    ("custom_index_o", "next_hit_instance_custom_index_i", true),
    ("shader_offset_o", "next_hit_instance_shader_offset_i", true),
];

/// Compares the hits of rays that end and are taken at random times, of all ports, with those that
/// `docs/integration/unit.md` states. A hit waits only for the one before it and for its weights.
pub fn run(bench: &mut Bench, unit: UnitParameters) -> Result<(), String> {
    let UnitParameters { contexts, divider_latency, step, .. } = unit;
    let hits: &[u64] = if step.features.queries == Queries::Full { &[HIT, BOX] } else { &[HIT] };
    let [ends, context, ready] = bench.inputs(["ends_i", "context_i", "ready_i"]);
    let [release, released, valid] = bench.outputs(["release_o", "context_o", "valid_o"]);
    let [status, t_denom] = bench.inputs(["status_i", "next_t_denom_i"]);
    let values: Vec<(usize, usize, bool)> = VALUES
        .iter()
        .filter_map(|&(output, input, is_of_hit)| Some((bench.output(output)?, bench.input(input)?, is_of_hit)))
        .collect();
    let weights: Vec<(usize, usize)> = [("u_o", "next_u_num_i"), ("v_o", "next_v_num_i")]
        .into_iter()
        .filter_map(|(output, input)| Some((bench.output(output)?, bench.input(input)?)))
        .collect();
    // Each ray with its context and what its hit must show.
    let mut waiting: VecDeque<(u64, Vec<u64>)> = VecDeque::new();
    let mut shown: Option<Vec<u64>> = None;
    let (mut waits, mut share) = (0, 0);
    for cycle in 0..CYCLES {
        // Few rays wait for some time, and nearly all for some.
        if cycle % (16 * contexts as usize) == 0 {
            share = bench.random.random_range(1..256);
        }
        let mut words = bench.words();
        for &(_, input) in &weights {
            words[input] = number(&mut bench.random).to_bits().into();
        }
        if !weights.is_empty() {
            words[t_denom] = number(&mut bench.random).to_bits().into();
        }
        let free: Vec<u64> =
            (0..contexts.into()).filter(|&free| waiting.iter().all(|(inside, _)| *inside != free)).collect();
        let is_end = !free.is_empty() && bench.random.random_range(0..256) < share;
        if is_end {
            words[context] = free[bench.random.random_range(0..free.len())];
            words[status] = if bench.chance(2) { HIT } else { words[status] };
        }
        let is_ready: bool = bench.random.random();
        (words[ends], words[ready]) = (is_end.into(), is_ready.into());
        words.iter().enumerate().for_each(|(input, &word)| bench.set(input, word));
        bench.simulator.settle();

        let outputs = values.iter().map(|(output, ..)| output).chain(weights.iter().map(|(output, _)| output));
        let found: Vec<u64> = outputs.map(|&output| bench.get(output)).collect();
        let found = (bench.get(valid) == 1).then_some(found);
        if found != shown {
            return Err(format!("cycle {cycle}: found {found:x?}, expected {shown:x?}"));
        }
        let has_room = shown.is_none() || is_ready;
        if has_room {
            shown = None;
        }
        if bench.get(release) == 1 {
            let first = waiting.pop_front().filter(|(inside, _)| has_room && *inside == bench.get(released));
            let Some((_, hit)) = first else {
                return Err(format!("cycle {cycle}: context {} is released", bench.get(released)));
            };
            (shown, waits) = (Some(hit), 0);
        }
        waits = if waiting.is_empty() || !has_room { 0 } else { waits + 1 };
        // Two cycles in the queue, and two of a stage for the quotients.
        if waits > divider_latency + 5 {
            return Err(format!("cycle {cycle}: a hit waits for {waits} cycles, and none is shown"));
        }
        if is_end {
            let is_hit = hits.contains(&words[status]);
            let masked = |word: u64, is_of_hit: bool| if is_hit || !is_of_hit { word } else { 0 };
            let mut hit: Vec<u64> =
                values.iter().map(|&(_, input, is_of_hit)| masked(words[input], is_of_hit)).collect();
            hit.extend(weights.iter().map(|&(_, input)| masked(weight(words[input], words[t_denom]), true)));
            waiting.push_back((words[context], hit));
        }
        bench.simulator.cycle();
    }
    Ok(())
}

/// The word of the quotient of two words; of NaN the canonical one.
fn weight(numerator: u64, denominator: u64) -> u64 {
    let quotient = f32::from_bits(numerator as u32) / f32::from_bits(denominator as u32);
    (if quotient.is_nan() { f32::NAN } else { quotient }).to_bits().into()
}
