//! Compressed nodes, decoded in binary64, in which the sum of two numbers of binary32 is rounded once.

use super::{Bench, CYCLES, number};
use raypath_traversal::blocks::NodeKind;
use std::collections::VecDeque;

/// Compares the bounds and the words of jobs that enter in every cycle. When they move is proved otherwise.
pub fn run(bench: &mut Bench, nodes: NodeKind) -> Result<(), String> {
    let [valid, ready, exists] = bench.inputs(["valid_i", "ready_i", "exists_0_i"]);
    let of_block: Vec<Option<usize>> = (0..20).map(|k| bench.input(&format!("word_{k}_i"))).collect();
    let [place, is_last, triangle, window] = bench.inputs(["place_i", "is_last_i", "triangle_0_i", "window_i"]);
    let (is_node, is_instance) = (bench.input("is_node_i"), bench.input("is_instance_i"));
    let [takes, is_shown, bound, passed] = bench.outputs(["ready_o", "valid_o", "bound_0_o", "word_0_o"]);
    let places = bench.outputs(["place_o", "is_last_o"]);
    let has_matrix = bench.output("word_9_o").is_some();
    // What must be shown: outputs, and their words.
    let mut inside: VecDeque<Vec<(usize, u64)>> = VecDeque::new();
    for cycle in 0..CYCLES {
        let mut words = bench.words();
        of_block[..3].iter().flatten().for_each(|&base| words[base] = number(&mut bench.random).to_bits().into());
        (words[valid], words[ready]) = (1, 1);
        // Only an instance, which is no node, has a matrix.
        is_node.zip(is_instance).iter().for_each(|(node, instance)| words[*instance] &= !words[*node]);
        words.iter().enumerate().for_each(|(input, &word)| bench.set(input, word));
        bench.simulator.settle();
        if bench.get(is_shown) == 1 {
            let expected = inside.pop_front().ok_or("a job that did not enter")?;
            if let Some((output, word)) = expected.iter().find(|(output, word)| bench.get(*output) != *word) {
                let (name, found) = (&bench.module.outputs()[*output].name, bench.get(*output));
                return Err(format!("cycle {cycle}: {name} is {found:#x}, expected {word:#x}"));
            }
        }
        if bench.get(takes) == 1 {
            let one = |input: Option<usize>| input.is_some_and(|input| words[input] == 1);
            let block: Vec<u64> = of_block.iter().map(|input| input.map_or(0, |input| words[input])).collect();
            let has_bounds = nodes != NodeKind::Wide8 || one(is_node);
            let is_upper = nodes == NodeKind::Wide8 && words[is_last] == 1;
            let mut job: Vec<(usize, u64)> = Vec::new();
            if has_bounds {
                let child = |k: usize| bounds(&block, nodes, k, words[exists + k] == 1);
                let children = if is_upper { 4..8 } else { 0..4 };
                job.extend((bound..).zip(children.flat_map(child)));
            }
            match nodes {
                NodeKind::Wide8 if !one(is_instance) => job.extend((0..9).map(|k| (passed + k, words[triangle + k]))),
                _ => {
                    job.extend((0..if has_matrix { 12 } else { 9 }).map(|k| (passed + k, block[nodes.matrix_word(k)])))
                }
            }
            let shown = if one(is_node) { window } else { place };
            job.extend([(places[0], words[shown]), (places[1], words[is_last])]);
            inside.push_back(job);
        }
        bench.simulator.cycle();
    }
    Ok(())
}

/// The words of the bounds of a child: the minima, then the maxima.
fn bounds(words: &[u64], nodes: NodeKind, child: usize, exists: bool) -> [u64; 6] {
    let byte = |place: usize| words[place / 4] >> (8 * (place % 4)) & 0xff;
    std::array::from_fn(|bound| {
        let (is_max, axis) = (bound >= 3, bound % 3);
        let power = match byte(12 + axis) {
            0 => 0.0,
            255 => f64::INFINITY,
            exponent => f64::from(exponent as i32 - 127).exp2(),
        };
        let addend = match nodes {
            _ if !exists => f64::INFINITY * if is_max { -1.0 } else { 1.0 },
            NodeKind::Wide8 => match byte(32 + 8 * (2 * axis + usize::from(is_max)) + child) {
                0 => 0.0,
                q => q as f64 * power,
            },
            _ => power * (1.0 + byte(16 + 6 * child + bound) as f64 / 256.0),
        };
        // The addend is a number of binary32, or infinite.
        let sum = (f64::from(f32::from_bits(words[axis] as u32)) + f64::from(addend as f32)) as f32;
        (if sum.is_nan() { f32::NAN } else { sum }).to_bits().into()
    })
}
