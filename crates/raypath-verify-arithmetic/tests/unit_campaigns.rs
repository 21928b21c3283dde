//! The units' campaigns find faulty units. The items of `verify` show that they pass the others.

use raypath_float::{Format, flags};
use raypath_hdl::{Builder, Error, Module, Wire};
use raypath_verify::{Level, Request, Verdict};
use raypath_verify_arithmetic::units::bench::Units;
use raypath_verify_arithmetic::units::{Dividers, conversions, division, small_formats, testfloat};
use std::sync::Arc;

/// One sum, which is also a difference, with a wrong last bit: its operands are reported, and nothing else.
#[test]
fn one_wrong_sum_is_found() -> Result<(), Box<dyn std::error::Error>> {
    let (mut units, flagged) = (binary32()?, with_flags()?);
    let wrong = [0x3f80_0000, 0x4080_0001].map(|code| Format::BINARY32.encode(code));
    units.add[0] = faulty(&units.add[0], |m, operands, outputs| {
        let is_wrong = operands[0].is(wrong[0]) & operands[1].is(wrong[1]);
        let place = m.concat(&[m.constant(outputs[0].width() - 1, 0), is_wrong]);
        vec![outputs[0] ^ place]
    })?;
    let verdict = regression("1/1", |request| testfloat(&units, &flagged, request));
    for expected in [
        "sum of 0x3f800000 and 0x40800001: 0x40a00000, expected 0x40a00001",
        "sum in two parts of 0x3f800000 and 0x40800001: differs from the unsplit unit",
        "difference of 0x3f800000 and 0xc0800001: 0x40a00000, expected 0x40a00001",
    ] {
        assert_reported(&verdict, expected);
    }
    let of_the_pair = |failure: &String| ["0x40800001", "0xc0800001"].iter().any(|b| failure.contains(b));
    assert!(verdict.failures.iter().all(of_the_pair), "{verdict:?}");
    Ok(())
}

/// Flags that are raised too seldom, and one in a split form.
#[test]
fn wrong_flags_are_found() -> Result<(), Box<dyn std::error::Error>> {
    let units = binary32()?;
    let without = |unit: &Arc<Module>, flag: u64| {
        faulty(unit, move |m, _, outputs| vec![outputs[0], outputs[1] & !m.constant(outputs[1].width(), flag)])
    };
    let mut flagged = with_flags()?;
    flagged.mul[0] = without(&flagged.mul[0], flags::UNDERFLOW)?;
    let verdict = regression("1/1", |request| testfloat(&units, &flagged, request));
    assert!(verdict.failures.iter().any(|failure| failure.contains(" with flags 0001, expected ")), "{verdict:?}");
    let mut flagged = with_flags()?;
    flagged.add[1] = without(&flagged.add[1], flags::INVALID)?;
    assert_reported(&regression("1/1", |request| testfloat(&units, &flagged, request)), "units with flags for 0x");
    Ok(())
}

/// Each unit with a plausible design fault: its campaign names the unit and the operands.
#[test]
fn faulty_units_are_found() -> Result<(), Box<dyn std::error::Error>> {
    // A fault in one split form of a unit is found in that form.
    let (mut units, flagged) = (binary32()?, with_flags()?);
    units.mul[2] = faulty(&units.mul[2], |m, _, outputs| vec![outputs[0] & !m.constant(outputs[0].width(), 1)])?;
    assert_reported(&regression("1/1", |request| testfloat(&units, &flagged, request)), "product in three parts of 0x");

    let mut units = binary32()?;
    units.compare = faulty(&units.compare, |m, operands, outputs| {
        let unlike = operands[0].top() ^ operands[1].top();
        vec![outputs[0], outputs[1] & !unlike, outputs[2] & m.constant(1, 1)]
    })?;
    assert_reported(
        &regression("1/1", |request| testfloat(&units, &flagged, request)),
        "equal of 0x00000000 and 0x80000000: false, expected true",
    );

    let mut units = binary32()?;
    units.encode = faulty(&units.encode, |m, operands, outputs| {
        let is_least = operands[0].lower(31).is(1);
        vec![outputs[0] ^ m.concat(&[m.constant(32, 0), is_least])]
    })?;
    assert_reported(
        &regression("1/1", |request| conversions(&units, request)),
        "encoding 0x00000001: 0x035800001, expected 0x035800000",
    );

    let mut units = binary32()?;
    units.decode = faulty(&units.decode, |m, operands, outputs| {
        let is_large = operands[0].lower(32).upper(3).is(0b110) & operands[0].bit(28);
        vec![outputs[0] ^ m.concat(&[m.constant(31, 0), is_large])]
    })?;
    assert_reported(&regression("1/1", |request| conversions(&units, request)), "decoding 0x");

    let of_small = |format| {
        let mut units = Units::new(format)?;
        if format.exponent() == 5 {
            units.add[1] = faulty(&units.add[1], |_, operands, outputs| {
                vec![operands[0].equals(operands[1]).mux(operands[0], outputs[0])]
            })?;
        }
        Ok(units)
    };
    assert_reported(
        &regression("1/1", |request| small_formats(&of_small, request)),
        "of e5s3: differs from the unsplit unit",
    );
    Ok(())
}

/// A wrong bit of one result, in one unit and one format each; and a unit that never answers.
#[test]
fn faulty_dividers_are_found() -> Result<(), Box<dyn std::error::Error>> {
    let wrong_in = |broken: Format, place: usize, wrong: u64| {
        move |format: Format| -> Result<Dividers, raypath_verify::Error> {
            let mut dividers = Dividers::new(format)?;
            if format == broken {
                let module = &mut dividers.units[place].module;
                // The outputs are ready, valid and result.
                *module = faulty(module, |_, _, outputs| {
                    let is_wrong = outputs[2].is(format.encode(wrong));
                    vec![outputs[0], outputs[1], outputs[2] ^ is_wrong.extend(outputs[2].width())]
                })?;
            }
            Ok(dividers)
        }
    };
    let small = Format::new(3, 4)?;
    for (broken, place, wrong, expected) in [
        (Format::BINARY32, 0, 0x3f80_0000, "converted_faulty_raypath_div_pipelined_e8s24_l1: 0x"),
        (Format::BINARY32, 6, 0x3f80_0000, "converted_faulty_raypath_rcp_iterative_e8s24_d3: 1 / 0x"),
        (Format::BINARY16, 3, 0x3c01, "converted_faulty_raypath_sqrt_pipelined_e5s11_l1: root of 0x"),
        (small, 8, 0x18, "converted_faulty_raypath_div_sqrt_iterative_e3s4_d1: 0x"),
    ] {
        assert_reported(&regression("1/1", |request| division(&wrong_in(broken, place, wrong), request)), expected);
    }

    let silent = |format: Format| -> Result<Dividers, raypath_verify::Error> {
        let mut dividers = Dividers::new(format)?;
        let module = &mut dividers.units[5].module;
        *module = faulty(module, |m, _, outputs| vec![outputs[0], outputs[1] & m.constant(1, 0), outputs[2]])?;
        Ok(dividers)
    };
    assert_reported(&regression("1/1", |request| division(&silent, request)), "0 results for ");
    Ok(())
}

#[test]
fn a_user_can_stop() -> Result<(), Box<dyn std::error::Error>> {
    let units = binary32()?;
    let mut proceed = |_| false;
    let verdict = testfloat(&units, &with_flags()?, &mut request(Level::Long, "1/1", &mut proceed))?;
    assert!(verdict.is_stopped && verdict.failures.is_empty(), "{verdict:?}");
    Ok(())
}

fn with_flags() -> Result<Units, Error> {
    Units::with_flags(Format::BINARY32)
}

fn binary32() -> Result<Units, Error> {
    Units::new(Format::BINARY32)
}

fn regression(shard: &str, run: impl FnOnce(&mut Request<'_>) -> Result<Verdict, raypath_verify::Error>) -> Verdict {
    run(&mut request(Level::Regression, shard, &mut |_| true)).expect("a verdict")
}

fn request<'a>(level: Level, shard: &str, proceed: &'a mut dyn FnMut(raypath_verify::Progress) -> bool) -> Request<'a> {
    Request { level, shard: shard.parse().expect("a shard"), ..Request::new(proceed) }
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
