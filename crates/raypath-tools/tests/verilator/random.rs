//! Random netlists side by side in one top module.

use crate::verilator::compare::agree;
use crate::verilator::netlists::{Contents, WIDTHS, netlist};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use raypath_hdl::Builder;

#[test]
fn random_netlists() {
    // A seed with which the linters find no register that stays constant.
    let mut random = ChaCha8Rng::seed_from_u64(200);
    let m = Builder::new("side_by_side");
    let inputs: Vec<_> = WIDTHS.iter().enumerate().map(|(n, &width)| m.input(&format!("in{n}_i"), width)).collect();
    for seed in 0..24 {
        let contents = Contents { operators: 60, registers: seed % 5, ..Contents::default() };
        let module = netlist(&format!("netlist{seed}"), &mut random, &contents);
        let names: Vec<String> = module.inputs().iter().map(|port| port.name.clone()).collect();
        let ports: Vec<_> = names.iter().map(String::as_str).zip(inputs.iter().copied()).collect();
        let outputs = m.instance(&format!("u_{}", module.name()), &module, &ports);
        for (n, output) in outputs.into_iter().enumerate() {
            m.output(&format!("{}_{n}_o", module.name()), output);
        }
    }
    agree(&m.finish().expect("a top"), &mut ChaCha8Rng::seed_from_u64(3), 5_000);
}
