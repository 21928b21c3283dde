//! The units' SystemVerilog: in Verilator against the same oracles, and in the linters.

use crate::units::exact::Exact;
use crate::units::small_formats;
use rand::Rng;
use raypath_float::Format;
use raypath_hdl::{Builder, Error, Module};
use raypath_tools::{Sources, Verilated};
use raypath_verify_arithmetic::units::bench::{OUTPUTS, PortFormat, UnitResults, Units};
use raypath_verify_arithmetic::units::operands::{generator, host_results, number};
use raypath_verify_arithmetic::units::oracle;
use std::sync::Arc;

/// The operands of a bench, with the expected results.
type Case = (u64, u64, UnitResults);

#[test]
fn every_small_operand_and_a_sample_of_binary32() -> Result<(), Box<dyn std::error::Error>> {
    let exact = Exact::new(3, 4);
    let benches: [(Arc<Module>, Vec<Case>); 3] = [
        (
            Units::new(exact.format)?.bench(PortFormat::Ieee)?,
            small_formats::cases(&exact, oracle::<3, 4>, PortFormat::Ieee).collect(),
        ),
        (
            Units::new(exact.format)?.bench(PortFormat::Recoded)?,
            small_formats::cases(&exact, oracle::<3, 4>, PortFormat::Recoded).collect(),
        ),
        (Units::new(Format::BINARY32)?.bench(PortFormat::Ieee)?, binary32_cases()),
    ];
    let modules = benches.each_ref().map(|(module, _)| module.clone());
    let folder = tempfile::tempdir()?;
    let verilated = Verilated::build(&side_by_side(&modules)?, folder.path())?;

    let cycles = benches.iter().map(|(_, cases)| cases.len()).max().unwrap_or_default();
    let in_cycle = |cycle: usize| benches.iter().map(move |(module, cases)| (module, cases[cycle % cases.len()]));
    let frames = (0..cycles).map(|cycle| in_cycle(cycle).flat_map(|(_, (a, b, _))| [a, b]).collect());
    let mut answered = 0;
    verilated.run(frames, |cycle, outputs| {
        for ((module, (a, b, expected)), seen) in in_cycle(cycle).zip(outputs.chunks_exact(OUTPUTS.len())) {
            assert_eq!(
                UnitResults::from_outputs(seen.try_into().expect("all outputs of a bench")),
                expected,
                "{}: {a:#x}, {b:#x}",
                module.name()
            );
            answered += 1;
        }
    })?;
    assert_eq!(answered, cycles * benches.len());
    Ok(())
}

#[test]
fn linters_are_silent() -> Result<(), Box<dyn std::error::Error>> {
    for (e, s) in [(8, 24), (3, 4), (5, 11), (8, 8), (3, 3), (11, 24)] {
        let folder = tempfile::tempdir()?;
        Sources::write(&Units::new(Format::new(e, s)?)?.bench(PortFormat::Ieee)?, folder.path())?.lint()?;
    }
    Ok(())
}

/// Half of the pairs have near exponents.
fn binary32_cases() -> Vec<Case> {
    let mut random = generator(5);
    let mut case = || {
        let a = number(&mut random);
        let other = number(&mut random);
        let near = (a & 0x7f80_0000).saturating_sub(random.next_u32() & 0x0f80_0000) | other & 0x807f_ffff;
        let b = if random.next_u32() & 1 == 0 { near } else { other };
        (a.into(), b.into(), host_results(f32::from_bits(a), f32::from_bits(b)))
    };
    (0..200_000).map(|_| case()).collect()
}

/// A module that instantiates others, with all their ports.
fn side_by_side(modules: &[Arc<Module>]) -> Result<Arc<Module>, Error> {
    let m = Builder::new("side_by_side");
    for module in modules {
        let name = module.name();
        let port = |port: &str| format!("{name}_{port}");
        let input = |name: &'static str| (name, m.input(&port(name), module.port_width(name).unwrap_or_default()));
        let outputs = m.instance(&format!("u_{name}"), module, &[input("a_i"), input("b_i")]);
        for (name, wire) in OUTPUTS.iter().zip(outputs) {
            m.output(&port(name), wire);
        }
    }
    m.finish()
}
