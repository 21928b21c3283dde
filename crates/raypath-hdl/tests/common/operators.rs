//! A module with every operator.

use raypath_hdl::{Builder, Label, Module};
use std::collections::BTreeSet;
use std::sync::Arc;

/// The operands of one evaluation. `a` and `b` have the width under test; `c` has one bit; `far` has 64 bits.
#[derive(Debug, Clone, Copy)]
pub struct Operands {
    pub a: u128,
    pub b: u128,
    pub c: u128,
    pub far: u128,
}

pub type Expected = Box<dyn Fn(Operands) -> u128>;

/// A module with an output for every operator, and the expected value of each output.
pub fn every_operator(width: u32) -> (Arc<Module>, Vec<(String, Expected)>) {
    let size = 1u128 << width;
    let m = Builder::new(&format!("operators{width}"));
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
    m.unused("unused_far", &[far]);
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
