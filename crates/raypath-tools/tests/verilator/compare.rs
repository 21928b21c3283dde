//! Lints a module, and runs it in both simulators with the same stimuli.

use crate::verilator::frames::agree_in_frames;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use raypath_hdl::Module;
use raypath_tools::{Sources, Verilated};
use std::sync::Arc;

/// Lints `top` and compares every output in `cycles` cycles; where there is a reset it is low in one cycle of eight.
pub fn agree(top: &Arc<Module>, random: &mut ChaCha8Rng, cycles: usize) {
    let folder = tempfile::tempdir().expect("a folder");
    Sources::write(top, folder.path()).expect("sources").lint().unwrap_or_else(|fault| panic!("{fault}"));
    let frames = frames(top, random, cycles);
    agree_in_frames(top, &Verilated::build(top, folder.path()).unwrap_or_else(|fault| panic!("{fault}")), &frames);
}

/// Random words, a third of them corner cases: zero, all ones, one, the top bit.
fn frames(top: &Module, random: &mut ChaCha8Rng, cycles: usize) -> Vec<Vec<u64>> {
    let widths: Vec<u32> = top.inputs().iter().map(|port| top.signal(port.signal).width).collect();
    let mut frame = || {
        let reset = top.has_reset().then(|| u64::from(random.random_range(0..8) != 0));
        let mut word = |&width: &u32| {
            let mask = u64::MAX >> (64 - width);
            match random.random_range(0..12) {
                0 => 0,
                1 => mask,
                2 => 1,
                3 => 1 << (width - 1),
                4 => random.random::<u64>() & 0x7f & mask,
                _ => random.random::<u64>() & mask,
            }
        };
        reset.into_iter().chain(widths.iter().map(&mut word)).collect()
    };
    (0..cycles).map(|_| frame()).collect()
}
