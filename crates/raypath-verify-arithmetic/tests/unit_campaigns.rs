//! The units' campaigns find faulty units. The items of `verify` show that they pass the others.

use raypath_float::Format;
use raypath_hdl::{Builder, Error, Module, Wire};
use raypath_verify::{Level, Request, Verdict};
use raypath_verify_arithmetic::units::bench::Units;
use raypath_verify_arithmetic::units::testfloat;
use std::sync::Arc;

/// One sum, which is also a difference, with a wrong last bit: its operands are reported, and nothing else.
#[test]
fn one_wrong_sum_is_found() -> Result<(), Box<dyn std::error::Error>> {
    let mut units = binary32()?;
    let wrong = [0x3f80_0000, 0x4080_0001].map(|code| Format::BINARY32.encode(code));
    units.add = faulty(&units.add, |m, operands, outputs| {
        let is_wrong = operands[0].is(wrong[0]) & operands[1].is(wrong[1]);
        let place = m.concat(&[m.constant(outputs[0].width() - 1, 0), is_wrong]);
        vec![outputs[0] ^ place]
    })?;
    let verdict = regression(|request| testfloat(&units, request));
    for expected in [
        "sum of 0x3f800000 and 0x40800001: 0x40a00000, expected 0x40a00001",
        "difference of 0x3f800000 and 0xc0800001: 0x40a00000, expected 0x40a00001",
    ] {
        assert_reported(&verdict, expected);
    }
    let of_the_pair = |failure: &String| ["0x40800001", "0xc0800001"].iter().any(|b| failure.contains(b));
    assert!(verdict.failures.iter().all(of_the_pair), "{verdict:?}");
    Ok(())
}

/// Units with a plausible design fault: the campaign names the unit and the operands.
#[test]
fn faulty_units_are_found() -> Result<(), Box<dyn std::error::Error>> {
    let mut units = binary32()?;
    units.compare = faulty(&units.compare, |m, operands, outputs| {
        let unlike = operands[0].top() ^ operands[1].top();
        vec![outputs[0], outputs[1] & !unlike, outputs[2] & m.constant(1, 1)]
    })?;
    assert_reported(
        &regression(|request| testfloat(&units, request)),
        "equal of 0x00000000 and 0x80000000: false, expected true",
    );
    let mut units = binary32()?;
    units.sqrt = faulty(&units.sqrt, |m, operands, outputs| {
        let is_subnormal = operands[0].lower(32).upper(9).less(m.constant(9, 130));
        vec![outputs[0] ^ m.concat(&[m.constant(32, 0), is_subnormal])]
    })?;
    assert_reported(&regression(|request| testfloat(&units, request)), "root of 0x00000001 and 0x00000000: ");
    Ok(())
}

#[test]
fn a_user_can_stop() -> Result<(), Box<dyn std::error::Error>> {
    let mut proceed = |_| false;
    let verdict = testfloat(&binary32()?, &mut Request { level: Level::Long, ..Request::new(&mut proceed) })?;
    assert!(verdict.is_stopped && verdict.failures.is_empty(), "{verdict:?}");
    Ok(())
}

fn binary32() -> Result<Units, Error> {
    Units::new(Format::BINARY32)
}

fn regression(run: impl FnOnce(&mut Request<'_>) -> Result<Verdict, raypath_verify::Error>) -> Verdict {
    run(&mut Request::new(&mut |_| true)).expect("a verdict")
}

fn assert_reported(verdict: &Verdict, expected: &str) {
    assert!(verdict.failures.iter().any(|failure| failure.contains(expected)), "{verdict:?}");
}

/// A wrapper of a unit with the same ports, whose outputs `fault` changes; `fault` receives the inputs and the outputs.
fn faulty(
    unit: &Arc<Module>,
    fault: impl for<'m> Fn(&'m Builder, &[Wire<'m>], &[Wire<'m>]) -> Vec<Wire<'m>>,
) -> Result<Arc<Module>, Error> {
    let m = Builder::new(&format!("faulty_{}", unit.name()));
    let names = || unit.inputs().iter().map(|port| port.name.as_str());
    let inputs: Vec<Wire<'_>> = names().map(|name| m.input(name, unit.port_width(name).unwrap_or_default())).collect();
    let connected: Vec<(&str, Wire<'_>)> = names().zip(inputs.iter().copied()).collect();
    let outputs = m.instance("u_unit", unit, &connected);
    for (port, wire) in unit.outputs().iter().zip(fault(&m, &inputs, &outputs)) {
        m.output(&port.name, wire);
    }
    m.finish()
}
