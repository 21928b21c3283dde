//! The set-up of rays, with the host's division.

use super::{Bench, CYCLES, NUMBERS};
use rand::RngExt;
use raypath_ops::{Binary32, from_words, to_canonical_words};
use raypath_traversal::set_up::{Division, Entry, axes, derived, divisions, is_refused};
use std::collections::VecDeque;

/// Compares the constants of rays that enter at random times.
pub fn run(bench: &mut Bench, divider_latency: u32) -> Result<(), String> {
    let [valid, context] = bench.inputs(["valid_i", "context_i"]);
    let [origin] = bench.inputs(["entry_origin_x_i"]);
    let [ready, has_constants, shown, refused] = bench.outputs(["ready_o", "valid_o", "context_o", "is_refused_o"]);
    let constants =
        bench.outputs(["inv_x_o", "inv_y_o", "inv_z_o", "shear_x_o", "shear_y_o", "shear_z_o", "kx_o", "ky_o", "kz_o"]);
    let mut expected: VecDeque<(u64, bool, Vec<u64>)> = VecDeque::new();
    for cycle in 0..CYCLES {
        let is_valid = !bench.chance(4);
        let tag = bench.random.random_range(0..1 << bench.inputs[context].1);
        let entry = entry(bench);
        bench.set(valid, is_valid.into());
        bench.set(context, tag);
        entry.iter().enumerate().for_each(|(k, &word)| bench.set(origin + k, word));
        bench.simulator.settle();
        let wrong = |what: String| Err(format!("cycle {cycle}: {what}"));
        if bench.get(has_constants) == 1 {
            let found: Vec<u64> = constants.iter().map(|&output| bench.get(output)).collect();
            let found = (bench.get(shown), bench.get(refused) == 1, found);
            let ray = expected.pop_front();
            if ray.as_ref() != Some(&found) {
                return wrong(format!("found {found:x?}, expected {ray:x?}"));
            }
        }
        if is_valid && bench.get(ready) == 1 {
            let (is_refused, words) = constants_of(&entry);
            expected.push_back((tag, is_refused, words));
        }
        // One enters every five cycles.
        if expected.len() as u32 > 4 + divider_latency / 5 {
            return wrong(format!("{} rays are inside", expected.len()));
        }
        bench.simulator.cycle();
    }
    Ok(())
}

/// Zeros, and numbers that differ from them in a bit or by one.
const NEAR_ZERO: [f32; 5] = [0.0, -0.0, 2.0, f32::from_bits(1), f32::from_bits(0x7fff_ffff)];

/// The words of a ray: often one of them is odd, or components of the direction have the same magnitude, or all are
/// zeros or near them.
pub fn entry(bench: &mut Bench) -> Vec<u64> {
    let is_odd = bench.chance(2).then(|| bench.random.random_range(0..8));
    let (is_tied, is_near_zero) = (bench.chance(3), bench.chance(4));
    let mut words: Vec<u64> = Vec::new();
    for place in 0..8 {
        let random = &mut bench.random;
        let number = match place {
            3..=5 if is_near_zero => NEAR_ZERO[random.random_range(0..NEAR_ZERO.len())],
            _ if is_odd == Some(place) || random.random_range(0..24) == 0 => {
                let all = [1e-40, -1e-40, 3e38, 0.0, NUMBERS[random.random_range(0..NUMBERS.len())]];
                all[random.random_range(0..all.len())]
            }
            4 | 5 if is_tied => f32::from_bits(words[place - 1] as u32) * [1.0, -1.0][random.random_range(0..2)],
            6 | 7 => random.random_range(0.0..9.0),
            _ => random.random_range(-3.0..3.0),
        };
        words.push(number.to_bits().into());
    }
    words
}

/// Whether a ray is refused, and the words of its constants.
pub fn constants_of(words: &[u64]) -> (bool, Vec<u64>) {
    let entry: Entry<Binary32> = from_words(Binary32, words);
    let axes = axes(Binary32, entry.dir);
    let quotient = |Division { dividend, divisor }: Division<Binary32>| {
        let (dividend, divisor): (f32, f32) = (dividend.into(), divisor.into());
        (dividend / divisor).into()
    };
    let derived = derived(Binary32, axes, divisions(Binary32, entry.dir, axes).map(quotient));
    let is_refused = is_refused(Binary32, &entry) | derived.is_too_short;
    let (mut words, mut more) = (Vec::new(), Vec::new());
    to_canonical_words(&derived.inv, &mut words);
    to_canonical_words(&derived.shear, &mut more);
    words.append(&mut more);
    to_canonical_words(&axes, &mut more);
    words.append(&mut more);
    (is_refused.into(), words)
}
