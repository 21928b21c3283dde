//! The units' SystemVerilog: in Verilator against the host's arithmetic, and in the linters.

use rand::Rng;
use raypath_float::{DivSqrt, Format};
use raypath_tools::{Sources, Verilated};
use raypath_verify_arithmetic::units::bench::{UnitResults, Units};
use raypath_verify_arithmetic::units::operands::{generator, host_results, number};

#[test]
fn a_sample_of_binary32() -> Result<(), Box<dyn std::error::Error>> {
    let mut random = generator(5);
    // Half of the pairs have near exponents.
    let cases: Vec<[u32; 2]> = (0..200_000)
        .map(|_| {
            let [a, other] = [(); 2].map(|()| number(&mut random));
            let near = (a & 0x7f80_0000).saturating_sub(random.next_u32() & 0x0f80_0000) | other & 0x807f_ffff;
            [a, if random.next_u32() & 1 == 0 { near } else { other }]
        })
        .collect();
    let folder = tempfile::tempdir()?;
    let verilated = Verilated::build(&Units::new(Format::BINARY32)?.bench()?, folder.path())?;
    let mut answered = 0;
    verilated.run(cases.iter().map(|case| case.map(u64::from).to_vec()), |cycle, outputs| {
        let found = UnitResults::from_outputs(outputs.try_into().expect("all outputs of a bench"));
        let [x, y] = cases[cycle].map(f32::from_bits);
        assert_eq!(found, host_results(x, y), "{x:e}, {y:e}");
        answered += 1;
    })?;
    assert_eq!(answered, cases.len());
    Ok(())
}

#[test]
fn linters_are_silent() -> Result<(), Box<dyn std::error::Error>> {
    for (e, s) in [(8, 24), (3, 4), (5, 11), (8, 8), (3, 3), (11, 24)] {
        let folder = tempfile::tempdir()?;
        let format = Format::new(e, s)?;
        Sources::write(&Units::new(format)?.bench()?, folder.path())?.lint()?;
        for module in
            [DivSqrt::QuotientOrRoot.pipelined(format, 3, 5)?, DivSqrt::Reciprocal.iterative(format, s + 2, 1)?]
        {
            Sources::write(&module, tempfile::tempdir()?.path())?.lint()?;
        }
    }
    Ok(())
}
