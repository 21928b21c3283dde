//! Random netlists. Without constant operands, linters accept their text.

use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use raypath_hdl::{Builder, Label, Module, Wire};
use std::sync::Arc;

/// The widths of every netlist's inputs.
pub const WIDTHS: [u32; 6] = [1, 7, 32, 33, 63, 64];

/// The size and the options of a netlist.
#[derive(Default)]
pub struct Contents<'a> {
    pub operators: usize,
    pub registers: usize,
    pub memories: usize,
    /// The modules of its instances, one instance each.
    pub inside: &'a [Arc<Module>],
    /// Whether operands may be constants.
    pub constants: bool,
}

struct Growth<'m, 'r> {
    m: &'m Builder,
    random: &'r mut ChaCha8Rng,
    wires: Vec<Wire<'m>>,
    /// Named wires, all of whose bits are read at the end. Only these may be sliced.
    named: Vec<Wire<'m>>,
    constants: bool,
}

pub fn netlist(name: &str, random: &mut ChaCha8Rng, contents: &Contents<'_>) -> Arc<Module> {
    let m = Builder::new(name);
    let &Contents { operators, registers, memories, inside, constants } = contents;
    let mut growth = Growth { m: &m, random, wires: Vec::new(), named: Vec::new(), constants };
    for (n, width) in WIDTHS.into_iter().enumerate() {
        growth.keep(m.input(&format!("in{n}_i"), width));
    }
    let mut pending = Vec::new();
    for n in 0..registers {
        let width = growth.width();
        let mut register = m.register(&format!("r{n}_q"), width);
        if growth.random.random_bool(0.5) {
            register = register.reset_to(growth.random.random::<u64>() >> (64 - width));
        }
        growth.keep(register.wire());
        pending.push(register);
    }
    let mut open = Vec::new();
    for n in 0..memories {
        let (depth, columns) = ([2, 3, 4, 8, 13][growth.random.random_range(0..5)], growth.random.random_range(1..4));
        let columns: Vec<_> = (0..columns).map(|column| (format!("c{column}"), growth.width())).collect();
        let titles: Vec<_> = columns.iter().map(|(title, width)| (title.as_str(), *width)).collect();
        let memory = m.memory(&format!("u_m{n}"), depth, &titles);
        memory.columns().into_iter().for_each(|column| growth.keep(column));
        open.push((memory, u32::BITS - (depth - 1).leading_zeros()));
    }
    for (n, module) in inside.iter().enumerate() {
        (0..operators / (inside.len() + 1)).for_each(|_| growth.step());
        let ports = module.inputs().iter().map(|port| (port.name.as_str(), module.signal(port.signal).width));
        let inputs: Vec<_> = ports.map(|(port, width)| (port, growth.pick(width))).collect();
        m.instance(&format!("u_i{n}"), module, &inputs).into_iter().for_each(|output| growth.keep(output));
    }
    for step in 0..operators {
        if step % 20 == 10 {
            m.section(format!("Part {}", step / 20));
        }
        growth.step();
    }
    for register in pending {
        let (enable, next) = (growth.pick(1), growth.pick(register.wire().width()));
        if growth.random.random_bool(0.5) {
            register.next_when(enable, next);
        } else {
            register.next(next);
        }
    }
    for (memory, width) in open {
        let word: Vec<_> = memory.columns().iter().map(|column| growth.pick(column.width())).collect();
        memory.write(growth.pick(1), growth.pick(width), &word);
        memory.read(growth.pick(1), growth.pick(width));
    }
    for n in 0..6 {
        m.output(&format!("out{n}_o"), growth.wires[growth.wires.len() - 1 - n]);
    }
    m.unused("unused_rest", &growth.named);
    drop(growth);
    m.finish().expect("a netlist")
}

impl<'m> Growth<'m, '_> {
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
        if self.constants && self.random.random_range(0..20) == 0 {
            return self.m.constant(width, self.random.random::<u64>() >> (64 - width));
        }
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

    /// A comparison whose result is not constant, because linters report constant results.
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
