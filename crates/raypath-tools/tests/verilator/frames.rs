//! Runs a module in both simulators with the same stimuli.

use raypath_hdl::{Module, Simulator};
use raypath_tools::Verilated;
use std::sync::Arc;

/// Compares every output in every cycle with that of the simulator, whose values it returns. A frame has the reset,
/// where there is one, and the inputs in their order.
pub fn agree_in_frames(top: &Arc<Module>, verilated: &Verilated, frames: &[Vec<u64>]) -> Vec<Vec<u64>> {
    let expected = simulate(top, frames);
    let mut seen = 0;
    verilated
        .run(frames.iter().cloned(), |cycle, outputs| {
            for ((port, &value), right) in top.outputs().iter().zip(outputs).zip(&expected[cycle]) {
                assert_eq!(value, *right, "{} in cycle {cycle}, inputs {:x?}", port.name, frames[cycle]);
            }
            seen += 1;
        })
        .expect("a run");
    assert_eq!(seen, frames.len());
    expected
}

fn simulate(top: &Arc<Module>, frames: &[Vec<u64>]) -> Vec<Vec<u64>> {
    let mut simulator = Simulator::new(top).expect("a simulator");
    let mut cycle = |frame: &Vec<u64>| {
        let words = match frame.as_slice() {
            [reset, words @ ..] if top.has_reset() => {
                simulator.set_reset(*reset == 0);
                words
            }
            words => words,
        };
        simulator.set_all(words.iter().copied());
        simulator.cycle();
        simulator.outputs().to_vec()
    };
    frames.iter().map(&mut cycle).collect()
}
