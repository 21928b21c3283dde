//! Queues that fill and empty.

use super::{Bench, CYCLES};
use rand::RngExt;
use std::collections::VecDeque;

/// Compares a queue with a list, in every cycle.
pub fn run(bench: &mut Bench, depth: u32) -> Result<(), String> {
    let ([push, pop], [valid]) = (bench.inputs(["push_i", "pop_i"]), bench.outputs(["valid_o"]));
    let columns = bench.inputs.len() - 2;
    let mut waiting: VecDeque<Vec<u64>> = VecDeque::new();
    let mut shown: Option<Vec<u64>> = None;
    let mut pushes = 0;
    for cycle in 0..CYCLES {
        // The queue is nearly empty for some time, and nearly full for some.
        if cycle % (16 * depth as usize) == 0 {
            pushes = bench.random.random_range(1..256);
        }
        let words = bench.words();
        words.iter().enumerate().for_each(|(input, &word)| bench.set(input, word));
        let has_room = waiting.len() + usize::from(shown.is_some()) < depth as usize;
        let (pushed, popped) = (has_room && bench.random.random_range(0..256) < pushes, bench.random.random());
        bench.set(push, pushed.into());
        bench.set(pop, u64::from(popped));
        bench.simulator.settle();
        let found: Vec<u64> = (0..columns).map(|column| bench.get(valid + 1 + column)).collect();
        let found = (bench.get(valid) == 1).then_some(found);
        if found != shown {
            return Err(format!("cycle {cycle}: found {found:x?}, expected {shown:x?}"));
        }
        if shown.is_none() || popped {
            shown = waiting.pop_front();
        }
        if pushed {
            waiting.push_back(words[push + 1..pop].to_vec());
        }
        bench.simulator.cycle();
    }
    Ok(())
}
