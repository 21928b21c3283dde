//! Every operator at widths near powers of two, compared with arithmetic on `u128`.

#[path = "common/operators.rs"]
mod every;

use every::{Expected, Operands, every_operator};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_hdl::{Builder, Module, Simulator};
use std::sync::Arc;

fn operands(width: u32) -> Vec<Operands> {
    let size = 1u128 << width;
    let w = u128::from(width);
    let edges: Vec<u128> =
        [0, 1, 2, w - 1, w, w + 1, 63, 64, 65, size / 2 - 1, size / 2, size / 2 + 1, size - 2, size - 1]
            .into_iter()
            .filter(|&value| value < size)
            .collect();
    let far = [0, 1, w - 1, w, 63, 64, 65, 127, 128, 1 << 31, 1 << 32, u128::from(u64::MAX)];
    let mut all = Vec::new();
    for &a in &edges {
        for &b in &edges {
            all.extend(far.iter().enumerate().map(|(n, &far)| Operands { a, b, c: n as u128 % 2, far }));
        }
    }
    let mut random = ChaCha8Rng::seed_from_u64(u64::from(width));
    for _ in 0..2_000 {
        let mut any = || u128::from(random.random::<u64>());
        let (a, b, c, far) = (any() % size, any() % size, any() % 2, any());
        // Half of the amounts are near the width.
        all.push(Operands { a, b, c, far: if far % 2 == 0 { far } else { far % 130 } });
    }
    all
}

fn compare(module: &Arc<Module>, expected: &[(String, Expected)], width: u32) {
    let mut simulator = Simulator::new(module).unwrap();
    assert!(module.outputs().iter().map(|port| &port.name).eq(expected.iter().map(|(name, _)| name)));
    for o in operands(width) {
        let outputs = simulator.evaluate([o.a, o.b, o.c, o.far].map(|operand| operand as u64));
        for ((name, expected), &output) in expected.iter().zip(outputs) {
            assert_eq!(u128::from(output), expected(o), "{name} at width {width} of {o:?}");
        }
    }
}

const WIDTHS: [u32; 9] = [1, 2, 7, 8, 31, 32, 33, 63, 64];

#[test]
fn operators_agree_with_wide_arithmetic() {
    for width in WIDTHS {
        let (module, expected) = every_operator(width);
        compare(&module, &expected, width);
    }
}

/// A module without registers that is instantiated is compiled as a function and called.
#[test]
fn operators_agree_inside_an_instance() {
    for width in WIDTHS {
        let (inner, expected) = every_operator(width);
        let m = Builder::new("outer");
        let inputs = [("a_i", width), ("b_i", width), ("c_i", 1), ("far_i", 64)];
        let inputs = inputs.map(|(name, width)| (name, m.input(name, width)));
        for (port, wire) in inner.outputs().iter().zip(m.instance("u_inner", &inner, &inputs)) {
            m.output(&port.name, wire);
        }
        compare(&m.finish().unwrap(), &expected, width);
    }
}

#[test]
fn bits_above_an_inputs_width_are_ignored() {
    let m = Builder::new("passes");
    let a = m.input("a_i", 7);
    m.output("a_o", a);
    m.output("more_o", a.extend(64));
    let mut simulator = Simulator::new(&m.finish().unwrap()).unwrap();
    assert_eq!(simulator.evaluate([0xffff_ff85]), [5, 5]);
    simulator.set(simulator.input("a_i").unwrap(), 0xffff_ff86);
    assert_eq!(simulator.evaluate([]), [6, 6]);
}

/// Gates with constant operands are simplified while a module is built: each has the value that it had.
#[test]
fn a_selection_between_constants_has_its_value() {
    for width in [1, 2] {
        let m = Builder::new("selection");
        let select = m.input("select_i", 1);
        let operands = [m.constant(width, 0), m.constant(width, 1), m.input("a_i", width)];
        for (t, if_true) in operands.iter().enumerate() {
            for (f, if_false) in operands.iter().enumerate() {
                // A constant of its own for each use, as where two parts of a description agree by chance.
                let copy = |k: usize| if k < 2 { m.constant(width, k as u64) } else { operands[k] };
                let selected = [select.mux(*if_true, *if_false), select.mux(copy(t), copy(f))];
                m.output(&format!("out_{t}_{f}_o"), m.concat(&selected));
            }
        }
        let mut simulator = Simulator::new(&m.finish().unwrap()).unwrap();
        for (is_true, value) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            for (k, &found) in simulator.evaluate([is_true, value]).iter().enumerate() {
                let (t, f) = (k / 3, k % 3);
                let chosen = if is_true == 1 { t } else { f };
                let expected = if chosen < 2 { chosen as u64 } else { value };
                assert_eq!(found, expected << width | expected, "width {width}, select {is_true}, {t}, {f}");
            }
        }
    }
}
