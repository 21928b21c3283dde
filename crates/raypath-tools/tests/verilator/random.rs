//! Random netlists side by side in one top module.

use crate::verilator::compare::agree_side_by_side;
use crate::verilator::netlists::{Contents, netlist};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

#[test]
fn random_netlists() {
    // A seed with which the linters find no register that stays constant.
    let mut random = ChaCha8Rng::seed_from_u64(200);
    agree_side_by_side((0..24).map(|seed| {
        let contents = Contents { operators: 60, registers: seed % 5, ..Contents::default() };
        netlist(&format!("netlist{seed}"), &mut random, &contents)
    }));
}
