//! Every operator at widths around the interesting ones, against arithmetic on `u128`.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_hdl::{Builder, InputPort, LANES, Label, LaneSimulator, Module, OutputPort, Simulator};
use std::collections::BTreeSet;
use std::sync::Arc;

/// The operands of one evaluation. `a` and `b` have the width under test; `c` has one bit; `far` has 64 bits.
#[derive(Debug, Clone, Copy)]
struct Operands {
    a: u128,
    b: u128,
    c: u128,
    far: u128,
}

type Expected = Box<dyn Fn(Operands) -> u128>;

/// A module with an output for every operator, and what each output must show.
fn every_operator(width: u32) -> (Arc<Module>, Vec<(String, Expected)>) {
    let size = 1u128 << width;
    let m = Builder::new("operators");
    let (a, b) = (m.input("a_i", width), m.input("b_i", width));
    let (c, far) = (m.input("c_i", 1), m.input("far_i", 64));
    let mut outputs: Vec<(String, Expected)> = Vec::new();
    let mut check = |name: &str, wire, expected: Expected| {
        m.output(name, wire);
        outputs.push((name.to_string(), expected));
    };

    check("not_o", !a, Box::new(move |o| size - 1 - o.a));
    check("and_o", a & b, Box::new(|o| bitwise(o, |a, b| a + b == 2)));
    check("or_o", a | b, Box::new(|o| bitwise(o, |a, b| a + b > 0)));
    check("xor_o", a ^ b, Box::new(|o| bitwise(o, |a, b| a != b)));
    check("add_o", a + b, Box::new(move |o| (o.a + o.b) % size));
    check("sub_o", a - b, Box::new(move |o| (o.a + size - o.b) % size));
    check("equal_o", a.equals(b), Box::new(|o| u128::from(o.a == o.b)));
    check("less_o", a.less(b), Box::new(|o| u128::from(o.a < o.b)));
    check("any_o", a.any(), Box::new(|o| u128::from(o.a > 0)));
    check("all_o", a.all(), Box::new(move |o| u128::from(o.a == size - 1)));
    let (by, far_by) = (b.lower(width.min(32)), far.lower(32));
    check("shl_o", a.shift_left(by), Box::new(move |o| shifted_left(o.a, o.b % (1 << 32), size)));
    check("shr_o", a.shift_right(by), Box::new(|o| shifted_right(o.a, o.b % (1 << 32))));
    check("shl_far_o", a.shift_left(far_by), Box::new(move |o| shifted_left(o.a, o.far % (1 << 32), size)));
    check("shr_far_o", a.shift_right(far_by), Box::new(|o| shifted_right(o.a, o.far % (1 << 32))));
    check("shl_six_o", a.shift_left(far.lower(6)), Box::new(move |o| shifted_left(o.a, o.far % 64, size)));
    check("shr_six_o", a.shift_right(far.lower(6)), Box::new(|o| shifted_right(o.a, o.far % 64)));
    check("shl_seven_o", a.shift_left(far.lower(7)), Box::new(move |o| shifted_left(o.a, o.far % 128, size)));
    check("shr_seven_o", a.shift_right(far.lower(7)), Box::new(|o| shifted_right(o.a, o.far % 128)));
    check("mux_o", c.mux(a, b), Box::new(|o| if o.c == 1 { o.a } else { o.b }));
    check("is_o", a.is((size - 1) as u64), Box::new(move |o| u128::from(o.a == size - 1)));
    check("replicate_o", c.replicate(width), Box::new(move |o| o.c * (size - 1)));
    check("constant_o", m.constant(width, (size / 3) as u64), Box::new(move |_| size / 3));
    let forward = m.forward("later", width);
    check("alias_o", forward.wire().named("once_more") + b, Box::new(move |o| (o.a + size - o.b) % size));
    forward.drive(a - b - b);

    let factor = width.min(64 - width);
    if factor > 0 {
        check("mul_o", a * b.lower(factor), Box::new(move |o| o.a * (o.b % (1 << factor))));
    }
    let top = width - 1;
    let cuts = [(0, 0), (top, 0), (top, top), (top, width / 2), (width / 2, width / 3)];
    for (high, low) in cuts.into_iter().filter(|&(high, low)| low <= high && high <= top).collect::<BTreeSet<_>>() {
        let expected = move |o: Operands| (o.a >> low) % (1 << (high - low + 1));
        check(&format!("bits_{high}_{low}_o"), a.bits(high, low), Box::new(expected));
    }
    if width < 64 {
        let rest = (64 - width).min(width);
        let joined = m.concat(&[a, b.upper(rest)]);
        check("concat_o", joined, Box::new(move |o| (o.a << rest) + (o.b >> (width - rest))));
        check("extend_o", a.extend(64), Box::new(|o| o.a));
    }
    let halves = m.concat(&[b.bit(0), c, a.bit(width - 1)]);
    check("bits_joined_o", halves, Box::new(move |o| (o.b % 2) * 4 + o.c * 2 + (o.a >> (width - 1))));

    let labels = [0, 1, size / 2, size - 1];
    let values = [a, b, !a, m.constant(width, 1)];
    let mut arms: Vec<(Label, _)> = Vec::new();
    for (place, &value) in labels.iter().enumerate() {
        if !labels[..place].contains(&value) {
            arms.push((Label { name: format!("Label{place}"), value: value as u64 }, values[place]));
        }
    }
    let selected = m.case(b, &arms, a ^ b);
    let chosen = move |o: Operands| match labels.iter().position(|&label| label == o.b) {
        Some(0) => o.a,
        Some(1) => o.b,
        Some(2) => size - 1 - o.a,
        Some(_) => 1,
        None => bitwise(o, |a, b| a != b),
    };
    check("case_o", selected, Box::new(chosen));
    (m.finish().unwrap(), outputs)
}

fn bitwise(o: Operands, rule: impl Fn(u128, u128) -> bool) -> u128 {
    (0..64).filter(|&bit| rule((o.a >> bit) % 2, (o.b >> bit) % 2)).map(|bit| 1 << bit).sum()
}

fn shifted_left(value: u128, amount: u128, size: u128) -> u128 {
    (0..amount.min(64)).fold(value, |value, _| value * 2 % size)
}

fn shifted_right(value: u128, amount: u128) -> u128 {
    (0..amount.min(64)).fold(value, |value, _| value / 2)
}

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
        // Half of the amounts near the interesting ones.
        all.push(Operands { a, b, c, far: if far % 2 == 0 { far } else { far % 130 } });
    }
    all
}

fn compare(module: &Arc<Module>, expected: &[(String, Expected)], width: u32) {
    let mut simulator = Simulator::new(module).unwrap();
    let inputs = ["a_i", "b_i", "c_i", "far_i"].map(|name| simulator.input(name).unwrap());
    let outputs: Vec<_> = expected.iter().map(|(name, _)| simulator.output(name).unwrap()).collect();
    for o in operands(width) {
        for (port, value) in inputs.into_iter().zip([o.a, o.b, o.c, o.far]) {
            simulator.set(port, value as u64);
        }
        simulator.settle();
        for ((name, expected), &output) in expected.iter().zip(&outputs) {
            assert_eq!(u128::from(simulator.get(output)), expected(o), "{name} at width {width} of {o:?}");
        }
    }
    compare_lanes(module, expected, width, inputs, &outputs);
}

/// The same, other operands in every lane.
fn compare_lanes(
    module: &Arc<Module>,
    expected: &[(String, Expected)],
    width: u32,
    inputs: [InputPort; 4],
    outputs: &[OutputPort],
) {
    let mut simulator = LaneSimulator::new(module).unwrap();
    for lanes in operands(width).chunks(LANES) {
        let of_lanes =
            |part: fn(Operands) -> u128| std::array::from_fn(|lane| lanes.get(lane).map_or(0, |o| part(*o) as u64));
        simulator.set(inputs[0], &of_lanes(|o| o.a));
        simulator.set(inputs[1], &of_lanes(|o| o.b));
        simulator.set(inputs[2], &of_lanes(|o| o.c));
        simulator.set(inputs[3], &of_lanes(|o| o.far));
        simulator.settle();
        for ((name, expected), &output) in expected.iter().zip(outputs) {
            let shown = simulator.get(output);
            for (lane, (&o, shown)) in lanes.iter().zip(shown).enumerate() {
                assert_eq!(u128::from(shown), expected(o), "{name} at width {width} of {o:?} in lane {lane}");
            }
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
    let a = simulator.input("a_i").unwrap();
    let (out, more) = (simulator.output("a_o").unwrap(), simulator.output("more_o").unwrap());
    simulator.set(a, 0xffff_ff85);
    simulator.settle();
    assert_eq!((simulator.get(out), simulator.get(more)), (5, 5));
}
