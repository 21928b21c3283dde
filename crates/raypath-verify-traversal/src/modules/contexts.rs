//! Contexts that are taken and released.

use super::{Bench, CYCLES};
use rand::RngExt;

/// Checks that a context that is given out is free, that each is given out once before one is given out again, and
/// that a free one is there within three cycles.
pub fn run(bench: &mut Bench, contexts: u32) -> Result<(), String> {
    let [take, release, released] = bench.inputs(["take_i", "release_i", "released_i"]);
    let [valid, given] = bench.outputs(["valid_o", "context_o"]);
    let mut used: Vec<u64> = Vec::new();
    let (mut taken, mut missing, mut releases) = (0, 0, 0);
    for cycle in 0..CYCLES {
        if cycle % (16 * contexts as usize) == 0 {
            releases = bench.random.random_range(1..256);
        }
        bench.simulator.settle();
        let (is_valid, context) = (bench.get(valid) == 1, bench.get(given));
        let is_free = context < contexts.into() && !used.contains(&context);
        let is_next = taken >= contexts || context == u64::from(taken);
        if is_valid && !(is_free && is_next) {
            return Err(format!("cycle {cycle}: context {context} is given out, {used:?} are in use"));
        }
        missing = if is_valid || used.len() == contexts as usize { 0 } else { missing + 1 };
        if missing > 3 {
            return Err(format!("cycle {cycle}: none is given out, and only {used:?} are in use"));
        }
        let takes = is_valid && bench.random.random();
        let releases = !used.is_empty() && bench.random.random_range(0..256) < releases;
        let place = bench.random.random_range(0..used.len().max(1));
        bench.set(take, takes.into());
        bench.set(release, releases.into());
        bench.set(released, used.get(place).copied().unwrap_or_default());
        if releases {
            used.swap_remove(place);
        }
        if takes {
            used.push(context);
            taken = contexts.min(taken + 1);
        }
        bench.simulator.cycle();
    }
    Ok(())
}
