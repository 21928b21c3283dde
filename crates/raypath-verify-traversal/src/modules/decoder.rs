//! Quantised nodes, decoded in binary64, in which the sum of two numbers of binary32 is rounded once.

use super::{Bench, CYCLES, number};
use std::collections::VecDeque;

/// Compares the bounds and the words of blocks that enter in every cycle. With instances, some leave twice. When they
/// move is proved otherwise.
pub fn run(bench: &mut Bench) -> Result<(), String> {
    let [valid, ready, word, exists] = bench.inputs(["valid_i", "ready_i", "word_0_i", "exists_0_i"]);
    let [takes, is_shown, bound, passed] = bench.outputs(["ready_o", "valid_o", "bound_0_o", "word_0_o"]);
    let of_instances = bench.input("is_instance_i").zip(bench.output("is_last_o"));
    let passes = if of_instances.is_some() { 12 } else { 9 };
    // Whether it is an instance, and what it shows.
    let mut inside: VecDeque<(bool, Vec<u64>)> = VecDeque::new();
    let mut is_second = false;
    for cycle in 0..CYCLES {
        let mut words = bench.words();
        (0..3).for_each(|axis| words[word + axis] = number(&mut bench.random).to_bits().into());
        (words[valid], words[ready]) = (1, 1);
        let is_instance = inside.front().is_some_and(|(is_instance, _)| *is_instance);
        of_instances.iter().for_each(|(input, _)| words[*input] = is_instance.into());
        words.iter().enumerate().for_each(|(input, &word)| bench.set(input, word));
        bench.simulator.settle();
        if bench.get(is_shown) == 1 {
            let found: Vec<u64> = (bound..bound + 24).chain(passed..passed + passes).map(|k| bench.get(k)).collect();
            let is_last = !is_instance || is_second;
            let expected = inside.front().map(|(_, block)| block);
            let has_last = of_instances.is_none_or(|(_, output)| (bench.get(output) == 1) == is_last);
            if expected != Some(&found) || !has_last {
                return Err(format!("cycle {cycle}: found {found:x?}, expected {expected:x?}, last: {is_last}"));
            }
            is_second = !is_last;
            if is_last {
                inside.pop_front();
            }
        }
        if bench.get(takes) == 1 {
            let is_instance = of_instances.is_some() && bench.chance(2);
            let block = [&bounds(&words[word..word + 10], &words[exists..exists + 4]), &words[word..word + passes]];
            inside.push_back((is_instance, block.concat()));
        }
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
