//! Every operator at the widths around machine words, alone and nested, where Verilog's rules on the widths of
//! expressions apply.

use crate::verilator::compare::agree;
use crate::verilator::every::every_operator;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use raypath_hdl::{Builder, Label, Module, Wire};
use std::cell::Cell;
use std::sync::Arc;

const WIDTHS: [u32; 7] = [1, 2, 8, 32, 33, 63, 64];

#[test]
fn every_operator_at_every_width() {
    agree(&operators(), &mut ChaCha8Rng::seed_from_u64(1), 20_000);
}

fn operators() -> Arc<Module> {
    let m = Builder::new("operators");
    let (bit, far, amount) = (m.input("bit_i", 1), m.input("far_i", 64), m.input("amount_i", 7));
    for width in WIDTHS {
        let input = |name: &str| m.input(&format!("{name}{width}_i"), width);
        let (a, b, c) = (input("a"), input("b"), input("c"));
        let show = |name: &str, wire: Wire<'_>| m.output(&format!("{name}{width}_o"), wire);
        m.section(format!("{width} bits"));
        let (single, _) = every_operator(width);
        let ports = [("a_i", a), ("b_i", b), ("c_i", bit), ("far_i", far)];
        let outputs = m.instance(&format!("u_single{width}"), &single, &ports);
        for (port, output) in single.outputs().iter().zip(outputs) {
            show(&format!("single_{}", port.stem()), output);
        }
        nested(&m, [a, b, c], amount, show);
    }
    m.finish().expect("a module")
}

/// Expressions whose context could widen an operand, keep a carry or change a sign.
fn nested<'m>(m: &'m Builder, [a, b, c]: [Wire<'m>; 3], amount: Wire<'m>, show: impl Fn(&str, Wire<'m>)) {
    let width = a.width();
    let cuts = Cell::new(0);
    // An expression's low bits; the others are left unread on purpose.
    let low = |wire: Wire<'m>, bits: u32| {
        if bits < wire.width() {
            cuts.set(cuts.get() + 1);
            m.unused(&format!("unused_cut{width}_{}", cuts.get()), &[wire]);
        }
        wire.lower(bits)
    };
    let factor = width.min(32);
    show("sum_less", (a + b).less(c));
    show("difference_less", (a - b).less(c - a));
    show("sum_equal", (a + b).equals(b + c));
    show("sum_right", (a + b).shift_right(amount));
    show("not_right", (!a).shift_right(amount));
    show("left_right", a.shift_left(amount).shift_right(amount));
    show("right_by_sum", a.shift_right(amount + amount));
    show("product_of_sums", (low(a, factor) + low(b, factor)) * !low(c, factor));
    show("product_of_not", low(!a, factor) * low(b - c, factor));
    show("subtractions", a - (b - c));
    show("mixed", (a & b) | (!a & c) | (b ^ c));
    let one = Label { name: "OpOne".to_string(), value: 1 };
    show("case_unnamed", m.case(c.lower(1), &[(one, a + b)], a ^ c) + c);
    show("any_of", (a & b).any() & !(a | c).all());
    show("muxes", a.any().mux(b.all().mux(a, b), c.less(a).mux(b + c, c)));
    show("compared", a.equals(b).equals(b.less(c)));
    show("sum_low", low(a + b, 1));
    if width < 64 {
        let sum = a.extend(width + 1) + b.extend(width + 1);
        show("carry", sum.top());
        show("sum", sum.lower(width));
        show("parts", m.concat(&[low(b + c, 1), a + b]));
        show("long", (a.extend(width + 1) - b.extend(width + 1)) ^ m.concat(&[c, b.top()]));
    }
}
