//! Rounding to shorter significands, alone and after a product, by search among all numbers of small formats and by the
//! host's binary64.

use crate::units::converter;
use crate::units::exact::Exact;
use raypath_float::{Format, Narrow, decode_narrow, mul_by_short_parts, mul_narrow_parts, narrow};
use raypath_verify_arithmetic::units::bench::{Simulated, chain};

/// The roundings to `bits` bits.
fn roundings(bits: u32, margins: &[u32]) -> impl Iterator<Item = Narrow> {
    margins.iter().flat_map(move |&margin| [false, true].map(|away| Narrow { bits, away, margin }))
}

/// The magnitudes of a format whose significands have at most `bits` bits, in order.
fn short(exact: &Exact, bits: u32) -> Vec<f64> {
    let is_short = |number: f64| number.to_bits() << (12 + bits - 1) == 0;
    let codes = 0..exact.ieee_code(f64::INFINITY);
    codes.map(|code| exact.ieee_value(code)).filter(|&number| is_short(number)).collect()
}

/// The rounded number, by search among the numbers `short`.
fn expected(exact: &Exact, short: &[f64], number: f64, to: Narrow) -> f64 {
    if !number.is_finite() {
        return number;
    }
    let (code, margin) = (exact.ieee_code(number.abs()), u64::from(to.margin));
    let infinity = exact.ieee_code(f64::INFINITY);
    let moved = if to.away { (code + margin).min(infinity) } else { code.saturating_sub(margin) };
    let moved = exact.ieee_value(moved);
    let rounded = match to.away {
        true => short.iter().copied().find(|&candidate| candidate >= moved).unwrap_or(f64::INFINITY),
        false => short.iter().copied().rfind(|&candidate| candidate <= moved).expect("zero"),
    };
    let least_normal = exact.ieee_value(1 << exact.format.fraction_width());
    (if rounded < 2.0 * least_normal { 0.0 } else { rounded }).copysign(number)
}

#[test]
fn every_number() {
    for (e, s) in [(3, 3), (3, 5), (4, 5), (5, 4), (5, 8), (6, 9)] {
        let exact = Exact::new(e, s);
        let format = exact.format;
        for to in (3..=s).flat_map(|bits| roundings(bits, &[0, 1, 4])) {
            let short = short(&exact, to.bits);
            let mut unit = converter(narrow(format, to));
            let mut decoder = converter(decode_narrow(format, to.bits));
            for (word, number) in exact.recoded_words() {
                let wanted = exact.ieee_code(expected(&exact, &short, number, to));
                let [rounded] = unit.run([word]);
                let [decoded] = decoder.run([rounded]);
                assert_eq!(decoded << (s - to.bits), wanted, "{format}, {to}, decoded: {word:#x} ({number})");
                let found = format.decode(rounded << (s - to.bits));
                assert_eq!(found, wanted, "{format}, {to}: {word:#x} ({number})");
                let code = exact.ieee_code(number);
                let by_software = match to.away {
                    true => format.narrow_away_from_zero(code, to.bits, to.margin),
                    false => format.narrow_toward_zero(code, to.bits, to.margin),
                };
                assert_eq!(by_software, wanted, "{format}, {to} in software: {code:#x} ({number})");
            }
        }
    }
}

/// A multiplier whole, and joined from two and from three parts.
fn multipliers(format: Format, operand: u32, to: Narrow) -> [Simulated; 3] {
    [1, 2, 3].map(|parts| converter(mul_narrow_parts(format, operand, to, parts).and_then(|parts| chain(&parts))))
}

#[test]
fn every_product() {
    // Twice the operand's bits are less than the format's, as many, and more.
    for (e, s, operand) in [(3, 5, 3), (4, 6, 3), (4, 7, 3), (4, 5, 4), (4, 5, 5), (4, 7, 6)] {
        let exact = Exact::new(e, s);
        let format = exact.format;
        let operands: Vec<(u64, f64)> = {
            let low = (1 << (s - operand)) - 1;
            let words = exact.recoded_words().into_iter();
            words.filter(|(word, _)| word & low == 0).map(|(word, number)| (word >> (s - operand), number)).collect()
        };
        for to in (3..=operand).flat_map(|bits| roundings(bits, &[0])) {
            let short = short(&exact, to.bits);
            let rounded: Vec<u64> = exact
                .ieee_codes()
                .map(|code| exact.ieee_code(expected(&exact, &short, exact.ieee_value(code), to)))
                .collect();
            let mut units = multipliers(format, operand, to);
            for &(a, x) in &operands {
                for &(b, y) in &operands {
                    let wanted = rounded[format.mul(exact.ieee_code(x), exact.ieee_code(y)) as usize];
                    for unit in &mut units {
                        let [found] = unit.run([a, b]);
                        let found = format.decode(found << (s - to.bits));
                        assert_eq!(found, wanted, "{format}, operands of {operand} bits, {to}: {x} times {y}");
                    }
                }
            }
        }
    }
}

/// Binary32: the host multiplies, in binary64 without rounding, and rounds to binary32.
#[test]
fn products_in_binary32() {
    use rand::{RngExt, SeedableRng};
    let mut rng = rand::rngs::ChaCha8Rng::seed_from_u64(1);
    let format = Format::BINARY32;
    for bits in 8..=24 {
        for to in roundings(bits, &[0]) {
            let mut units = multipliers(format, bits, to);
            for _ in 0..3_000 {
                // Exponents for ordinary, very large and very small products; some fractions of ones or zeros.
                let exponent = [0_u32, 1, 63, 64, 65, 126, 127, 128, 190, 254, 255][rng.random_range(0..11)];
                let mut number = |exponent: u32| {
                    let fraction = [rng.random(), rng.random(), u32::MAX, 0, 1 << 22][rng.random_range(0..5)];
                    let low = (1 << (24 - bits)) - 1;
                    rng.random::<u32>() & 1 << 31 | exponent << 23 | fraction >> 9 & !low
                };
                let a = number(exponent);
                let b = number((exponent + 128) % 256);
                let [x, y] = [a, b].map(|code| f64::from(f32::from_bits(code)));
                let nearest = f64::from((x * y) as f32);
                let wanted = rounded(nearest, to);
                for unit in &mut units {
                    let [found] = unit.run([a, b].map(|code| format.encode(code.into()) >> (24 - bits)));
                    let found = format.decode(found << (24 - bits));
                    let wanted = format.from_f64(wanted);
                    assert_eq!(found, wanted, "{to}: {a:#x} times {b:#x}");
                }
            }
        }
    }
}

/// A multiplier by a short factor, whole and joined from parts, in gates and with `*`.
fn multipliers_by_short(format: Format, bits: u32) -> Vec<Simulated> {
    let forms = [1, 2, 3].into_iter().flat_map(|parts| [false, true].map(|inferred| (parts, inferred)));
    let unit = |(parts, inferred)| mul_by_short_parts(format, bits, parts, inferred).and_then(|parts| chain(&parts));
    forms.map(|form| converter(unit(form))).collect()
}

#[test]
fn every_product_by_a_short_factor() {
    for (e, s, bits) in [(3, 5, 3), (4, 6, 3), (4, 6, 5), (4, 5, 5)] {
        let exact = Exact::new(e, s);
        let format = exact.format;
        let low = (1 << (s - bits)) - 1;
        let mut units = multipliers_by_short(format, bits);
        for (a, x) in exact.recoded_words() {
            for (b, y) in exact.recoded_words().into_iter().filter(|(word, _)| word & low == 0) {
                let wanted = format.mul(exact.ieee_code(x), exact.ieee_code(y));
                for unit in &mut units {
                    let [found] = unit.run([a, b >> (s - bits)]);
                    assert_eq!(format.decode(found), wanted, "{format}, a factor of {bits} bits: {x} times {y}");
                }
            }
        }
    }
}

/// Binary32 by words of 8 bits: the host multiplies.
#[test]
fn products_by_words_in_binary32() {
    use rand::{RngExt, SeedableRng};
    let mut rng = rand::rngs::ChaCha8Rng::seed_from_u64(2);
    let format = Format::BINARY32;
    let mut units = multipliers_by_short(format, 8);
    for word in 0..256_u32 {
        let y = word as f32;
        for _ in 0..200 {
            let x = f32::from_bits(rng.random());
            for unit in &mut units {
                let [found] = unit.run([format.encode(x.to_bits().into()), format.encode(y.to_bits().into()) >> 16]);
                let wanted = format.canonical((x * y).to_bits().into());
                assert_eq!(format.decode(found), wanted, "{x:e} times {word}");
            }
        }
    }
}

/// A binary32 number, rounded in binary64.
fn rounded(number: f64, to: Narrow) -> f64 {
    if !number.is_finite() || number == 0.0 {
        return number;
    }
    let unit = 2_f64.powi(number.abs().log2().floor() as i32 - to.bits as i32 + 1);
    let units = number.abs() / unit;
    let magnitude = unit * if to.away { units.ceil() } else { units.floor() };
    let kept = if magnitude < 2_f64.powi(-125) { 0.0 } else { magnitude };
    (if kept >= 2_f64.powi(128) { f64::INFINITY } else { kept }).copysign(number)
}

#[test]
fn significands_that_a_format_does_not_have_are_refused() {
    let format = Format::BINARY16;
    for bits in [2, 12] {
        let to = Narrow { bits, away: true, margin: 0 };
        for error in [narrow(format, to).err(), mul_narrow_parts(format, 11, to, 1).err()] {
            let said = error.expect("refused").to_string();
            assert!(said.contains(&format!("{bits} bits, expected 3 to 11")), "{said}");
        }
    }
}
