//! Clock gates in Verilator: registers behind gates beside registers without, which read each other.

use crate::verilator::compare::agree;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use raypath_hdl::{Builder, Module};
use std::sync::Arc;

/// A chain in which each register reads the one before it, behind another clock. A gate that is late or early by a
/// time step shows another value.
fn chain() -> Arc<Module> {
    let m = Builder::new("chain");
    let data = m.input("data_i", 16);
    m.section("Chain");
    let mut word = data;
    for place in 0..8 {
        let register = m.register(&format!("word_{place}_q"), 16);
        let register = if place % 3 == 0 { register.reset_to(place) } else { register };
        // The enable of the third gate depends on registers behind others.
        let enable = if place == 4 { word.bit(3) } else { data.bit(place as u32) };
        match place % 2 {
            0 => register.next_gated(enable.named(&format!("load_{place}")), word),
            _ => register.next(word),
        }
        word = register.wire();
        m.output(&format!("word_{place}_o"), word);
    }
    m.finish().expect("a chain")
}

#[test]
fn gated_registers_agree() {
    agree(&chain(), &mut ChaCha8Rng::seed_from_u64(5), 20_000);
}
