//! Lints a module, and runs it in both simulators with the same stimuli.

use crate::verilator::frames::agree_in_frames;
use crate::verilator::netlists::WIDTHS;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_hdl::{Builder, Module};
use raypath_tools::{Sources, Verilated};
use std::sync::Arc;

/// Lints `top` and compares every output in `cycles` cycles; where there is a reset it is low in one cycle of eight.
pub fn agree(top: &Arc<Module>, random: &mut ChaCha8Rng, cycles: usize) {
    let folder = tempfile::tempdir().expect("a folder");
    Sources::write(top, folder.path()).expect("sources").lint().unwrap_or_else(|fault| panic!("{fault}"));
    let frames = frames(top, random, cycles);
    agree_in_frames(top, &Verilated::build(top, folder.path()).unwrap_or_else(|fault| panic!("{fault}")), &frames);
}

/// Compares the modules side by side in one top module, which drives the inputs of all.
pub fn agree_side_by_side(modules: impl IntoIterator<Item = Arc<Module>>) {
    let m = Builder::new("side_by_side");
    let inputs: Vec<_> = WIDTHS.iter().enumerate().map(|(n, &width)| m.input(&format!("in{n}_i"), width)).collect();
    for module in modules {
        let names: Vec<String> = module.inputs().iter().map(|port| port.name.clone()).collect();
        let ports: Vec<_> = names.iter().map(String::as_str).zip(inputs.iter().copied()).collect();
        let outputs = m.instance(&format!("u_{}", module.name()), &module, &ports);
        for (n, output) in outputs.into_iter().enumerate() {
            m.output(&format!("{}_{n}_o", module.name()), output);
        }
    }
    agree(&m.finish().expect("a top"), &mut ChaCha8Rng::seed_from_u64(3), 5_000);
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
