//! The set-up of rays, with the host's division; with instances, new rays and rays that enter one share it.

use super::{Bench, CYCLES, NUMBERS};
use rand::RngExt;
use raypath_ops::{Binary32, from_words, to_canonical_words};
use raypath_traversal::set_up::{Division, Entry, axes, derived, divisions, is_refused};
use std::collections::VecDeque;

/// The cycles in which a ray uses the divider.
const TURN: usize = 5;

/// Compares who enters in each cycle, and the constants of each. With instances, a new ray may have no free context;
/// without, the module has no ports for them.
pub fn run(bench: &mut Bench, divider_latency: u32) -> Result<(), String> {
    let has_instances = bench.input("transformed_valid_i").is_some();
    let [valid, free, context, origin] = bench.inputs(["valid_i", "free_i", "context_i", "entry_origin_x_i"]);
    let [meaningless] = bench.inputs(["is_meaningless_i"]);
    let [is_transformed, is_last] = bench.inputs(["transformed_valid_i", "transformed_is_last_i"]);
    let [transformed_context, transformed] = bench.inputs(["transformed_context_i", "transformed_x_i"]);
    let [ready, takes, enters, origin_context] =
        bench.outputs(["ready_o", "transformed_ready_o", "enters_instance_o", "origin_context_o"]);
    let [object, has_constants, refused] = bench.outputs(["object_x_o", "valid_o", "is_refused_o"]);
    let [shown, is_instance] = bench.outputs(["context_o", "is_instance_o"]);
    let constants =
        bench.outputs(["inv_x_o", "inv_y_o", "inv_z_o", "shear_x_o", "shear_y_o", "shear_z_o", "kx_o", "ky_o", "kz_o"]);
    let mut expected: VecDeque<(u64, bool, bool, Vec<u64>)> = VecDeque::new();
    // The second outcome of an instance waits; the kept origin; the cycle from which on the set-up is free; whether a
    // new ray has the next turn.
    let mut instance: Option<(u64, Vec<u64>)> = None;
    let (mut kept, mut ready_from, mut yields) = (vec![0; 3], 0, false);
    for cycle in 0..CYCLES {
        let (is_valid, is_free) = (!bench.chance(3), !has_instances || !bench.chance(3));
        let (given, tag, words) = (entry(bench), bench.words()[context], bench.words());
        bench.set(valid, u64::from(is_valid && is_free));
        bench.set(context, tag);
        let is_meaningless = bench.chance(8);
        bench.set(meaningless, is_meaningless.into());
        given.iter().enumerate().for_each(|(k, &word)| bench.set(origin + k, word));
        // An outcome is an origin, or the direction that follows one; a new one comes at random times.
        let is_first = has_instances && instance.is_none() && bench.chance(3);
        let (number, vector) = match &instance {
            Some(last) => last.clone(),
            None => (words[transformed_context], entry(bench)[..3].to_vec()),
        };
        let waits = instance.is_some() && !bench.chance(4);
        if has_instances {
            bench.set(free, is_free.into());
            bench.set(is_transformed, u64::from(is_first || waits));
            bench.set(is_last, if is_first || waits { waits.into() } else { words[is_last] });
            bench.set(transformed_context, number);
            (0..3).for_each(|k| bench.set(transformed + k, vector[k]));
        }
        bench.simulator.settle();

        let wrong = |what: String| Err(format!("cycle {cycle}: {what}"));
        let is_ready = cycle >= ready_from;
        let chosen = waits && !(yields && is_free);
        let found = [bench.get(ready) == 1, has_instances && bench.get(enters) == 1];
        if found != [is_ready && !chosen, is_ready && chosen] {
            return wrong(format!("a new ray may enter, and one in an instance does: {found:?}"));
        }
        let is_taken = bench.get(takes) == 1;
        if (is_first || waits) && is_taken != (is_first || is_ready && chosen) {
            return wrong(format!("an outcome is taken: {is_taken}"));
        }
        if found[1] {
            let object: Vec<u64> = (0..3).map(|k| bench.get(object + k)).collect();
            if object != kept || bench.get(origin_context) != number {
                return wrong(format!("the origin is {object:x?}, expected {kept:x?}"));
            }
        }
        if bench.get(has_constants) == 1 {
            let found = constants.iter().map(|&output| bench.get(output)).collect();
            let of_instance = has_instances && bench.get(is_instance) == 1;
            let found = (bench.get(shown), of_instance, bench.get(refused) == 1, found);
            let ray = expected.pop_front();
            if ray.as_ref() != Some(&found) {
                return wrong(format!("found {found:x?}, expected {ray:x?}"));
            }
        }
        if is_ready {
            yields = chosen;
            let words = [&kept[..], &vector, &[0, 0]].concat();
            let words = if chosen { words } else { given };
            if chosen || is_valid && is_free {
                let (is_refused, constants) = constants_of(&words);
                let is_refused = is_refused || is_meaningless && !chosen;
                expected.push_back((if chosen { number } else { tag }, chosen, is_refused, constants));
                ready_from = cycle + TURN;
            }
            if chosen {
                instance = None;
            }
        }
        if is_first {
            kept = vector;
            instance = Some((number, entry(bench)[3..6].to_vec()));
        }
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
fn entry(bench: &mut Bench) -> Vec<u64> {
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
fn constants_of(words: &[u64]) -> (bool, Vec<u64>) {
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
