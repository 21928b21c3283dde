//! The weights of hits, with the host's division.

use super::{Bench, CYCLES, number};
use std::collections::VecDeque;

/// Compares the weights of rays that are taken and leave at random times.
pub fn run(bench: &mut Bench, divider_latency: u32) -> Result<(), String> {
    let [valid, context, ready] = bench.inputs(["valid_i", "context_i", "ready_i"]);
    let operands = bench.inputs(["u_num_i", "v_num_i", "t_denom_i", "is_hit_i"]);
    let [take, is_complete, shown, u, v] = bench.outputs(["take_o", "valid_o", "context_o", "u_o", "v_o"]);
    let mut inside: VecDeque<[u64; 3]> = VecDeque::new();
    let (mut refused, mut waits) = (0, 0);
    for cycle in 0..CYCLES {
        let (is_valid, is_ready, tag) = (!bench.chance(4), bench.chance(2), bench.words()[context]);
        bench.set(valid, is_valid.into());
        bench.set(ready, is_ready.into());
        bench.set(context, tag);
        bench.simulator.settle();
        let (takes, leaves) = (bench.get(take) == 1, bench.get(is_complete) == 1);
        if leaves {
            let found = [bench.get(shown), bench.get(u), bench.get(v)];
            if inside.front() != Some(&found) {
                return Err(format!("cycle {cycle}: found {found:x?}, expected {:x?}", inside.front()));
            }
        }
        // A ray needs the divider for two cycles.
        refused = if is_valid && !takes && !leaves { refused + 1 } else { 0 };
        waits = if leaves || inside.is_empty() { 0 } else { waits + 1 };
        if takes && !is_valid || refused > 1 || waits > divider_latency + 2 {
            return Err(format!("cycle {cycle}: a ray is taken: {takes}, refused: {refused}, waits: {waits}"));
        }
        if leaves && is_ready {
            inside.pop_front();
        }
        bench.simulator.cycle();
        if takes {
            let [u, v, t_denom] = [(); 3].map(|()| number(&mut bench.random));
            let is_hit = !bench.chance(4);
            let words = [u, v, t_denom].map(|number| u64::from(number.to_bits())).into_iter().chain([is_hit.into()]);
            operands.into_iter().zip(words).for_each(|(input, word)| bench.set(input, word));
            let own = |numerator: f32| {
                if is_hit { weight(numerator.to_bits().into(), t_denom.to_bits().into()) } else { 0 }
            };
            inside.push_back([tag, own(u), own(v)]);
        }
    }
    Ok(())
}

/// The word of the quotient of two words; of NaN the canonical one.
pub fn weight(numerator: u64, denominator: u64) -> u64 {
    let quotient = f32::from_bits(numerator as u32) / f32::from_bits(denominator as u32);
    (if quotient.is_nan() { f32::NAN } else { quotient }).to_bits().into()
}
