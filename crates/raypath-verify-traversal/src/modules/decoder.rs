//! Quantised nodes, decoded in binary64, in which the sum of two numbers of binary32 is rounded once.

use super::{Bench, CYCLES, number};
use std::collections::VecDeque;

/// Compares the bounds and the triangle of blocks that enter in every cycle. When they move is proved.
pub fn run(bench: &mut Bench) -> Result<(), String> {
    let [valid, ready, word, exists] = bench.inputs(["valid_i", "ready_i", "word_0_i", "exists_0_i"]);
    let [is_shown, bound, triangle] = bench.outputs(["valid_o", "bound_0_o", "triangle_0_o"]);
    let mut inside: VecDeque<Vec<u64>> = VecDeque::new();
    for cycle in 0..CYCLES {
        let mut words = bench.words();
        (0..3).for_each(|axis| words[word + axis] = number(&mut bench.random).to_bits().into());
        (words[valid], words[ready]) = (1, 1);
        words.iter().enumerate().for_each(|(input, &word)| bench.set(input, word));
        bench.simulator.settle();
        if bench.get(is_shown) == 1 {
            let found: Vec<u64> = (bound..bound + 24).chain(triangle..triangle + 9).map(|k| bench.get(k)).collect();
            let block = inside.pop_front();
            if block.as_ref() != Some(&found) {
                return Err(format!("cycle {cycle}: found {found:x?}, expected {block:x?}"));
            }
        }
        inside
            .push_back([&bounds(&words[word..word + 10], &words[exists..exists + 4]), &words[word..word + 9]].concat());
        bench.simulator.cycle();
    }
    Ok(())
}

/// The words of the bounds of a node: for each child the minima, then the maxima.
fn bounds(words: &[u64], exists: &[u64]) -> Vec<u64> {
    let byte = |place: usize| words[place / 4] >> (8 * (place % 4)) & 0xff;
    let bound = |bound: usize| {
        let (child, is_max, axis) = (bound / 6, bound % 6 >= 3, bound % 3);
        let addend = match byte(12 + axis) {
            _ if exists[child] == 0 => f64::INFINITY * if is_max { -1.0 } else { 1.0 },
            0 => 0.0,
            255 => f64::INFINITY,
            exponent => f64::from(exponent as i32 - 127).exp2() * (1.0 + byte(16 + bound) as f64 / 256.0),
        };
        let sum = (f64::from(f32::from_bits(words[axis] as u32)) + addend) as f32;
        (if sum.is_nan() { f32::NAN } else { sum }).to_bits().into()
    };
    (0..24).map(bound).collect()
}
