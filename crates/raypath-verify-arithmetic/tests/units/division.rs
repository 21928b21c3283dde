//! The SystemVerilog of dividers and square roots in Verilator beside the netlist simulator, in every cycle.

use rand::RngExt;
use raypath_float::{DivSqrt, Format};
use raypath_hdl::{Module, Simulator};
use raypath_tools::Verilated;
use raypath_verify_arithmetic::units::operands::{generator, number};
use std::sync::Arc;

#[test]
fn verilator_agrees_in_every_cycle() -> Result<(), Box<dyn std::error::Error>> {
    let format = Format::BINARY32;
    let modules = [
        DivSqrt::QuotientOrRoot.iterative(format, 3, 7)?,
        DivSqrt::QuotientOrRoot.pipelined(format, 9, 7)?,
        DivSqrt::Reciprocal.iterative(format, 2, 0)?,
    ];
    for (seed, module) in (1..).zip(modules) {
        let folder = tempfile::tempdir()?;
        let verilated = Verilated::build(&module, folder.path())?;
        let frames = frames(&module, seed);
        let mut simulator = Simulator::new(&module)?;
        let mut results = 0;
        verilated.run(frames.clone(), |cycle, seen| {
            let frame = &frames[cycle];
            simulator.set_reset(frame[0] == 0);
            simulator.set_all(frame[1..].iter().copied());
            simulator.cycle();
            assert_eq!(seen, simulator.outputs(), "{} in cycle {cycle}", module.name());
            // Valid and ready.
            results += seen[1] & frame[2];
        })?;
        assert!(results > 1_000, "{}: {results} results", module.name());
    }
    Ok(())
}

/// The reset, then the inputs: a job in most cycles, a sink that sometimes waits, and few resets.
fn frames(module: &Arc<Module>, seed: u64) -> Vec<Vec<u64>> {
    let mut random = generator(seed);
    let mut frame = || {
        let mut words = vec![u64::from(random.random_range(0..5_000) != 0)];
        for port in module.inputs() {
            words.push(match port.name.as_str() {
                "valid_i" => u64::from(random.random_range(0..8) != 0),
                "ready_i" => u64::from(random.random_range(0..4) != 0),
                "a_i" | "b_i" => Format::BINARY32.encode(number(&mut random).into()),
                name => random.random_range(0..1 << module.port_width(name).unwrap_or_default()),
            });
        }
        words
    };
    (0..100_000).map(|_| frame()).collect()
}
