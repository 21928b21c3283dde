//! Lints a module, and runs it in both simulators with the same stimuli.

use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use raypath_hdl::{Module, Simulator};
use raypath_tools::{Sources, Verilated};
use std::sync::Arc;

/// Lints `top` and compares every output in `cycles` cycles; where there is a reset it is low in one cycle of eight.
pub fn agree(top: &Arc<Module>, random: &mut ChaCha8Rng, cycles: usize) {
    let folder = tempfile::tempdir().expect("a folder");
    Sources::write(top, folder.path()).expect("sources").lint().unwrap_or_else(|fault| panic!("{fault}"));
    let frames = frames(top, random, cycles);
    let expected = simulate(top, &frames);
    let verilated = Verilated::build(top, folder.path()).unwrap_or_else(|fault| panic!("{fault}"));
    let mut seen = 0;
    verilated
        .run(frames.iter().cloned(), |cycle, outputs| {
            for ((port, &value), right) in top.outputs().iter().zip(outputs).zip(&expected[cycle]) {
                assert_eq!(value, *right, "{} in cycle {cycle}, inputs {:x?}", port.name, frames[cycle]);
            }
            seen += 1;
        })
        .expect("a run");
    assert_eq!(seen, cycles);
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

fn simulate(top: &Arc<Module>, frames: &[Vec<u64>]) -> Vec<Vec<u64>> {
    let mut simulator = Simulator::new(top).expect("a simulator");
    let inputs: Vec<_> = top.inputs().iter().map(|port| simulator.input(&port.name).expect("an input")).collect();
    let outputs: Vec<_> = top.outputs().iter().map(|port| simulator.output(&port.name).expect("an output")).collect();
    let mut cycle = |frame: &Vec<u64>| {
        let words = match frame.as_slice() {
            [reset, words @ ..] if top.has_reset() => {
                simulator.set_reset(*reset == 0);
                words
            }
            words => words,
        };
        inputs.iter().zip(words).for_each(|(&port, &word)| simulator.set(port, word));
        simulator.cycle();
        outputs.iter().map(|&port| simulator.get(port)).collect()
    };
    frames.iter().map(&mut cycle).collect()
}
