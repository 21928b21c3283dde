//! Exceptions: units compared with exact arithmetic, and jobs with a circuit that collects exceptions.

use crate::features::check;
use raypath_float::{Format, add_parts, flags, mul_parts};
use raypath_hdl::{Module, Simulator};
use raypath_ops::{Flagged, Rules};
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
            for port in module.inputs() {
                let wire = part.input(&port.name).expect("a port");
                part.set(wire, values[port.stem()]);
            }
            part.settle();
            let outputs = module.outputs().iter();
            values = outputs
                .map(|port| (port.stem().to_string(), part.get(part.output(&port.name).expect("a port"))))
                .collect();
        }
        let result = values.get("sum").or_else(|| values.get("product")).expect("a result");
        [*result, values["flags"]]
    }
}

#[test]
fn units_raise_what_exact_arithmetic_says() {
    for (e, s) in [(3, 3), (3, 4), (4, 3), (4, 4)] {
        let format = Format::new(e, s).expect("a format");
        for parts in 1..=3 {
            let mut add = Chain::new(&add_parts(format, parts, true).expect("an adder"));
            let mut multiply = Chain::new(&mul_parts(format, parts, true).expect("a multiplier"));
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

/// Exceptions of jobs, for the features that change the arithmetic, and with units of one to three parts.
#[test]
fn jobs_raise_what_the_model_collects() {
    let alone = Features { exception_flags: true, ..Features::OFF };
    let more = Features { range: true, conservative: true, accumulators: Accumulators::Two, ..alone };
    let small = Config::DEFAULT.lanes(Lanes::Four);
    check(small.features(alone).rules(Rules::Chisel), 1_500);
    check(small.features(more).unit_latency(UnitLatency::Two), 1_500);
    check(small.features(more).unit_latency(UnitLatency::Three).control(Control::Credit), 1_500);
}

#[test]
fn both_circuits_have_the_same_names_of_bits() {
    let hardware = [flags::INEXACT, flags::UNDERFLOW, flags::OVERFLOW, flags::INVALID];
    assert_eq!(hardware, [Flagged::INEXACT, Flagged::UNDERFLOW, Flagged::OVERFLOW, Flagged::INVALID]);
}
