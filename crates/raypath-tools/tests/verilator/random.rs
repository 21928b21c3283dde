//! Random netlists side by side in one top module.

use crate::compare::agree;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_hdl::{Builder, Label, Module, Wire};
use std::sync::Arc;

const NETLISTS: u64 = 24;

#[test]
fn random_netlists() {
    let modules: Vec<_> = (0..NETLISTS).map(netlist).collect();
    let m = Builder::new("side_by_side");
    let inputs: Vec<_> = WIDTHS.iter().enumerate().map(|(n, &width)| m.input(&format!("in{n}_i"), width)).collect();
    for module in &modules {
        let names: Vec<String> = module.inputs().iter().map(|port| port.name.clone()).collect();
        let ports: Vec<_> = names.iter().map(String::as_str).zip(inputs.iter().copied()).collect();
        let outputs = m.instance(&format!("u_{}", module.name()), module, &ports);
        for (n, output) in outputs.into_iter().enumerate() {
            m.output(&format!("{}_{n}_o", module.name()), output);
        }
    }
    agree(&m.finish().expect("a top"), &mut ChaCha8Rng::seed_from_u64(3), 5_000);
}

/// The widths of every netlist's inputs.
const WIDTHS: [u32; 6] = [1, 7, 32, 33, 63, 64];

struct Growth<'m> {
    m: &'m Builder,
    random: ChaCha8Rng,
    wires: Vec<Wire<'m>>,
    /// Named wires, all of whose bits are read at the end; only they may be sliced.
    named: Vec<Wire<'m>>,
}

fn netlist(seed: u64) -> Arc<Module> {
    let m = Builder::new(&format!("netlist{seed}"));
    let mut growth =
        Growth { m: &m, random: ChaCha8Rng::seed_from_u64(100 + seed), wires: Vec::new(), named: Vec::new() };
    for (n, width) in WIDTHS.into_iter().enumerate() {
        growth.keep(m.input(&format!("in{n}_i"), width));
    }
    let mut registers = Vec::new();
    for n in 0..seed % 5 {
        let width = growth.width();
        let mut register = m.register(&format!("r{n}_q"), width);
        if n % 2 == 1 {
            register = register.reset_to(growth.random.random::<u64>() >> (64 - width));
        }
        growth.keep(register.wire());
        registers.push(register);
    }
    for step in 0..60 {
        if step % 20 == 10 {
            m.section(format!("Part {}", step / 20));
        }
        growth.step();
    }
    for register in registers {
        let (enable, next) = (growth.pick(1), growth.pick(register.wire().width()));
        if growth.random.random_bool(0.5) {
            register.next_when(enable, next);
        } else {
            register.next(next);
        }
    }
    for n in 0..4 {
        m.output(&format!("out{n}_o"), growth.wires[growth.wires.len() - 1 - n]);
    }
    m.unused("unused_rest", &growth.named);
    drop(growth);
    m.finish().expect("a netlist")
}

impl<'m> Growth<'m> {
    fn keep(&mut self, wire: Wire<'m>) {
        self.wires.push(wire);
        self.named.push(wire);
    }

    fn width(&mut self) -> u32 {
        match self.random.random_range(0..6) {
            0 | 1 => 1,
            2 => 64,
            _ => self.random.random_range(1..=64),
        }
    }

    /// A recent wire, sliced or extended to `width`.
    fn pick(&mut self, width: u32) -> Wire<'m> {
        let back = self.random.random_range(0..self.wires.len().min(16));
        let place = self.wires.len() - 1 - back;
        let wire = self.wires[place];
        if wire.width() == width {
            return wire;
        }
        if wire.width() < width {
            return wire.extend(width);
        }
        let named = wire.named(&format!("cut{}", self.named.len()));
        self.wires[place] = named;
        self.named.push(named);
        let low = self.random.random_range(0..=named.width() - width);
        named.bits(low + width - 1, low)
    }

    /// A comparison whose result no tool can derive: a constant result would be a lint.
    fn less(&self, a: Wire<'m>) -> Wire<'m> {
        let inputs = &self.named[..WIDTHS.len()];
        let (bit, some, all) = (inputs[0], inputs[4], inputs[5]);
        let other = if a.width() == 64 { self.m.concat(&[bit, some]) } else { some.lower(a.width()) };
        (a + all.lower(a.width())).less(other)
    }

    fn step(&mut self) {
        let width = self.width();
        let (a, b, bit) = (self.pick(width), self.pick(width), self.pick(1));
        let m = self.m;
        let wire = match self.random.random_range(0..19) {
            0 => !a,
            1 => a & b,
            2 => a | b,
            3 => a ^ b,
            4 => a + b,
            5 => a - b,
            6 => self.pick(width.min(32)) * self.pick(width.min(32)),
            7 => a.equals(b),
            8 => self.less(a),
            9 => a.any(),
            10 => a.all(),
            11 => a.shift_left(self.pick(width.min(32))),
            12 => a.shift_right(self.pick(width.min(7))),
            13 => a.shift_right(self.pick(width.min(32))),
            14 => bit.mux(a, b),
            15 if width > 1 => {
                let selector = self.pick(2);
                let arms = [(0, !a), (1, !a), (3, b)]
                    .map(|(value, wire)| (Label { name: format!("Label{value}"), value }, wire));
                m.case(selector, &arms, a)
            }
            16 if width < 63 => m.concat(&[bit, a, bit]),
            17 => a & m.constant(width, self.random.random::<u64>() >> (64 - width)),
            _ => {
                let wire = (a + b).named(&format!("n{}", self.named.len()));
                self.keep(wire);
                return;
            }
        };
        self.wires.push(wire);
    }
}
