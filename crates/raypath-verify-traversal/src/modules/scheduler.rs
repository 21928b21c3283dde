//! Sources that are served in turn.

use super::{Bench, CYCLES};
use rand::RngExt;

/// Compares the grants with those to the first source after the one that was granted last, in a circle.
pub fn run(bench: &mut Bench) -> Result<(), String> {
    let ([request], [grant]) = (bench.inputs(["request_i"]), bench.outputs(["grant_o"]));
    let count = bench.inputs[request].1;
    let mut first = 0;
    for cycle in 0..CYCLES {
        if cycle % 16 == 0 {
            bench.simulator.restart();
            first = 0;
        }
        let requested: u64 = bench.random.random_range(0..1 << count);
        bench.set(request, requested);
        bench.simulator.settle();
        let granted = (first..first + count).map(|place| place % count).find(|place| requested >> place & 1 == 1);
        let expected = granted.map_or(0, |source| 1 << source);
        let found = bench.get(grant);
        if found != expected {
            return Err(format!("cycle {cycle}: {requested:#b} gets {found:#b}, expected {expected:#b}"));
        }
        first = granted.map_or(first, |source| source + 1);
        bench.simulator.cycle();
    }
    Ok(())
}
