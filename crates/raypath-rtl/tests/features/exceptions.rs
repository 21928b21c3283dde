//! Exceptions: units compared with exact arithmetic, and jobs with a circuit that collects exceptions.

use crate::features::check;
use raypath_float::{Format, Product, add, flags, mul, mul_with_residue};
use raypath_hdl::{Module, Simulator, Technology, divide};
use raypath_ops::{Flagged, Layout, RESIDUE_TINY, Rules};
use raypath_rtl::{Accumulators, Config, Control, Features, Lanes, UnitLatency};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The exceptions of a result, from the exact result: a sum or product of short numbers, which binary64 represents.
fn expected(format: Format, operands: [f64; 2], exact: f64, rounded: u64) -> u64 {
    if operands.iter().any(|operand| operand.is_nan()) {
        return 0;
    }
    if exact.is_nan() {
        return flags::INVALID;
    }
    if operands.iter().any(|operand| operand.is_infinite()) {
        return 0;
    }
    let rounded = format.to_f64(rounded);
    let least_normal = format.to_f64(1 << (format.significand() - 1));
    if rounded.is_infinite() {
        flags::OVERFLOW | flags::INEXACT
    } else if rounded == exact {
        0
    } else if exact.abs() < least_normal {
        flags::UNDERFLOW | flags::INEXACT
    } else {
        flags::INEXACT
    }
}

/// The parts of a unit, connected in order.
struct Chain(Vec<Simulator>);

impl Chain {
    fn new(parts: &[Arc<Module>]) -> Self {
        Self(parts.iter().map(|part| Simulator::new(part).expect("a part")).collect())
    }

    /// The result and the flags.
    fn run(&mut self, a: u64, b: u64) -> [u64; 2] {
        let mut values = BTreeMap::from([("a".to_string(), a), ("b".to_string(), b)]);
        for part in &mut self.0 {
            let module = Arc::clone(part.module());
            let outputs = part.evaluate(module.inputs().iter().map(|port| values[port.stem()]));
            let named = module.outputs().iter().zip(outputs);
            values = named.map(|(port, &value)| (port.stem().to_string(), value)).collect();
        }
        let result = values.get("sum").or_else(|| values.get("product")).expect("a result");
        [*result, values["flags"]]
    }
}

#[test]
fn units_raise_what_exact_arithmetic_says() {
    for (e, s) in [(3, 3), (3, 4), (4, 3), (4, 4)] {
        let format = Format::new(e, s).expect("a format");
        for parts in [1, 2, 3, 8] {
            let divided = |unit: Result<Arc<Module>, _>| {
                divide(&unit.expect("a unit"), parts, Technology::Gates, 0.0).expect("parts")
            };
            let mut add = Chain::new(&divided(add(format, true)));
            let mut multiply = Chain::new(&divided(mul(format, Product::Booth, true)));
            let mut seen = 0;
            for a in 0..1_u64 << format.ieee_width() {
                for b in 0..1_u64 << format.ieee_width() {
                    let operands = [a, b].map(|code| format.to_f64(code));
                    let [x, y] = operands;
                    let [p, q] = [a, b].map(|code| format.encode(code));
                    for (unit, exact, rounded) in
                        [(&mut add, x + y, format.add(a, b)), (&mut multiply, x * y, format.mul(a, b))]
                    {
                        let [result, found] = unit.run(p, q);
                        assert_eq!(format.decode(result), format.canonical(rounded), "{format}: {x}, {y}: {exact}");
                        let expected = expected(format, operands, exact, rounded);
                        assert_eq!(found, expected, "{format} in {parts}: {x}, {y}: {exact}, {result:x}");
                        seen |= found;
                    }
                }
            }
            assert_eq!(seen, 15);
        }
    }
}

/// The residues of all products of small formats and of random ones of binary32: of two that are equal after rounding,
/// that of the greater exact magnitude is greater; the unit has those of the model.
#[test]
fn residues_have_the_order_of_exact_products() {
    for (e, s) in [(3, 3), (4, 3), (3, 4), (4, 4), (5, 5)] {
        let format = Format::new(e, s).expect("a format");
        let least = 2.0_f64.powi(2 - (1 << (e - 1)));
        let units = [Product::Booth, Product::Inferred, Product::Dsp]
            .map(|product| Simulator::new(&mul_with_residue(format, product).expect("a multiplier")).expect("a unit"));
        let mut by_product: BTreeMap<u64, Vec<(f64, u32)>> = BTreeMap::new();
        let mut units = units;
        for a in 0..1_u64 << format.ieee_width() {
            for b in 0..1_u64 << format.ieee_width() {
                let exact = format.to_f64(a) * format.to_f64(b);
                let product = format.mul(a, b);
                if !format.to_f64(product).is_finite() {
                    continue;
                }
                let residue = Layout { exponent: e, significand: s }.residue(a, b);
                let is_tiny = exact != 0.0 && exact.abs() < least;
                assert_eq!(residue >= RESIDUE_TINY, is_tiny, "{format}: {exact}");
                for unit in &mut units {
                    unit.evaluate([a, b].map(|code| format.encode(code)));
                    let [found, rounded] =
                        ["residue_o", "product_o"].map(|port| unit.get(unit.output(port).expect("a port")));
                    assert_eq!(format.decode(rounded), product);
                    let has = if is_tiny { found >> 25 == 1 } else { found == u64::from(residue) };
                    assert!(has, "{format}: {exact}, {found:x}, expected {residue:x}");
                }
                if !is_tiny {
                    by_product.entry(product).or_default().push((exact.abs(), residue));
                }
            }
        }
        let mut apart = 0;
        for mut equal in by_product.into_values() {
            equal.sort_by(|x, y| x.0.total_cmp(&y.0));
            for pair in equal.windows(2) {
                assert_eq!(pair[0].0.total_cmp(&pair[1].0), pair[0].1.cmp(&pair[1].1), "{format}: {pair:?}");
                apart += u32::from(pair[0].1 < pair[1].1);
            }
        }
        assert!(apart > 10, "{apart}");
    }
}

/// Exceptions of jobs, for the features that change the arithmetic, and with units of one to three parts.
#[test]
fn jobs_raise_what_the_model_collects() {
    let alone = Features { exception_flags: true, ..Features::OFF };
    let more = Features { range: true, conservative: true, accumulators: Accumulators::Two, ..alone };
    let small = Config::DEFAULT.lanes(Lanes::Four);
    check(small.features(alone).rules(Rules::Chisel), 1_500);
    check(small.features(more).unit_latency(UnitLatency::TWO), 1_500);
    check(small.features(more).unit_latency(UnitLatency::THREE).control(Control::Credit), 1_500);
}

#[test]
fn both_circuits_have_the_same_names_of_bits() {
    let hardware = [flags::INEXACT, flags::UNDERFLOW, flags::OVERFLOW, flags::INVALID];
    assert_eq!(hardware, [Flagged::INEXACT, Flagged::UNDERFLOW, Flagged::OVERFLOW, Flagged::INVALID]);
}
