//! Quantised nodes, decoded in binary64, in which the sum of two numbers of binary32 is rounded once.

use super::{Bench, CYCLES, number};
use std::collections::VecDeque;

/// A block: its context, its bounds and the words of its triangle.
struct Block {
    context: u64,
    bounds: Vec<u64>,
    triangle: Vec<u64>,
}

/// Compares the bounds and the triangle of blocks that enter and leave at random times.
pub fn run(bench: &mut Bench) -> Result<(), String> {
    let [valid, context, ready] = bench.inputs(["valid_i", "context_i", "ready_i"]);
    let [word, exists] = bench.inputs(["word_0_i", "exists_0_i"]);
    let [takes, reads, asked] = bench.outputs(["ready_o", "read_o", "read_context_o"]);
    let [is_shown, shown, bound, triangle] = bench.outputs(["valid_o", "context_o", "bound_0_o", "triangle_0_o"]);
    let mut inside: VecDeque<Block> = VecDeque::new();
    // The context that was read, which is at the outputs.
    let mut read: Option<u64> = None;
    for cycle in 0..CYCLES {
        let (is_valid, is_ready) = (!bench.chance(4), !bench.chance(3));
        let mut words = bench.words();
        (0..3).for_each(|axis| words[word + axis] = number(&mut bench.random).to_bits().into());
        words.iter().enumerate().for_each(|(input, &word)| bench.set(input, word));
        bench.set(valid, is_valid.into());
        bench.set(ready, is_ready.into());
        bench.simulator.settle();
        let wrong = |what: String| Err(format!("cycle {cycle}: {what}"));
        let has_block = bench.get(is_shown) == 1;
        if has_block != read.is_some() || has_block && read != Some(bench.get(shown)) {
            return wrong(format!("context {} is shown: {has_block}, read was {read:?}", bench.get(shown)));
        }
        if has_block {
            let Some(block) = inside.front() else { return wrong("no block is inside".to_string()) };
            let outputs = |first: usize, count: usize| (first..first + count).map(|k| bench.get(k)).collect::<Vec<_>>();
            let found = (bench.get(shown), outputs(bound, 24), outputs(triangle, 9));
            if found.0 != block.context || found.1 != block.bounds || found.2 != block.triangle {
                let Block { context, bounds, triangle } = block;
                return wrong(format!("found {found:x?}, expected {:x?}", (context, bounds, triangle)));
            }
            if is_ready {
                inside.pop_front();
            }
        }
        let moves = !has_block || is_ready;
        // Behind the outputs is a place for one block.
        let next = inside.get(usize::from(!moves)).map(|block| block.context);
        if (bench.get(takes) == 1) != moves || (bench.get(reads) == 1) != (moves && next.is_some()) {
            return wrong(format!("a block enters: {}, is read: {}", bench.get(takes), bench.get(reads)));
        }
        if moves {
            if next.is_some_and(|next| next != bench.get(asked)) {
                return wrong(format!("context {} is read, expected {next:?}", bench.get(asked)));
            }
            read = next;
        }
        if is_valid && moves {
            let triangle = words[word..word + 9].to_vec();
            let bounds = bounds(&words[word..word + 10], &words[exists..exists + 4]);
            inside.push_back(Block { context: words[context], bounds, triangle });
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
