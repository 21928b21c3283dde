//! Mutation of the printer: each of its translations is broken once in the printed text, and the comparison of
//! Verilator with the netlist simulator must show it.
//!
//! All faults are in one text, each at an output of its own, so that Verilator compiles once. An output without a fault
//! must agree.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_hdl::{Builder, Label, Module, Simulator, verilog};
use raypath_tools::{Verilated, write};
use std::sync::Arc;

/// An output, a part of the text of its line or of its module, and the wrong translation.
type Fault = (&'static str, &'static str, &'static str);

/// Faults in the line that assigns the output.
const IN_LINES: &[Fault] = &[
    ("and_o", "a_i & b_i", "a_i | b_i"),
    ("or_o", "a_i | b_i", "a_i ^ b_i"),
    ("xor_o", "a_i ^ b_i", "a_i & b_i"),
    ("not_o", "~a_i", "a_i"),
    ("differs_o", "a_i != b_i", "a_i == b_i"),
    ("add_o", "a_i + b_i", "a_i - b_i"),
    ("sub_o", "a_i - b_i", "b_i - a_i"),
    ("mul_o", "16'(a_i) * 16'(b_i)", "16'(a_i) + 16'(b_i)"),
    ("factor_o", "16'(b_i)", "16'(a_i)"),
    ("equal_o", "a_i == b_i", "a_i != b_i"),
    ("less_o", "a_i < b_i", "a_i <= b_i"),
    ("signed_o", "a_i < b_i", "$signed(a_i) < $signed(b_i)"),
    ("any_o", "|a_i", "&a_i"),
    ("all_o", "&a_i", "^a_i"),
    ("left_o", "a_i << b_i[2:0]", "a_i >> b_i[2:0]"),
    ("right_o", "a_i >> b_i[2:0]", "$signed(a_i) >>> b_i[2:0]"),
    ("mux_o", "s_i ? a_i : b_i", "s_i ? b_i : a_i"),
    ("concat_o", "{a_i, b_i}", "{b_i, a_i}"),
    ("replicate_o", "{8{s_i}}", "{7'd0, s_i}"),
    ("slice_o", "a_i[5:2]", "a_i[6:3]"),
    ("bit_o", "a_i[3]", "a_i[4]"),
    ("decimal_o", "8'd165", "8'd164"),
    ("hexadecimal_o", "32'h3f80_0000", "32'h3f80_0001"),
    ("grouped_o", "(a_i + b_i) >> 1'b1", "a_i + (b_i >> 1'b1)"),
    ("alias_o", "later", "a_i"),
];

/// Faults in the text of a module that has the output.
const IN_MODULES: &[Fault] = &[
    ("label", "= 2'd1;", "= 2'd2;"),
    ("fallback", "default: x_o = b_i;", "default: x_o = a_i;"),
    ("held", "if (s_i)", "if (!s_i)"),
    ("started", "<= 8'd3;", "<= 8'd2;"),
    ("clocked", "<= a_i;", "<= b_i;"),
    ("connected", ".a_i, .b_i", ".a_i (b_i), .b_i"),
    ("stored", ".write_address_i (a_i[1:0])", ".write_address_i (b_i[1:0])"),
];

/// Outputs without a fault.
const RIGHT: [&str; 2] = ["right_sum_o", "right_state_o"];

fn lines() -> Arc<Module> {
    let m = Builder::new("lines");
    let (a, b, s) = (m.input("a_i", 8), m.input("b_i", 8), m.input("s_i", 1));
    let by = b.lower(3);
    let one = m.constant(1, 1);
    let forward = m.forward("later", 8);
    for (name, wire) in [
        ("and_o", a & b),
        ("or_o", a | b),
        ("xor_o", a ^ b),
        ("not_o", !a),
        ("differs_o", !a.equals(b)),
        ("add_o", a + b),
        ("sub_o", a - b),
        ("mul_o", a * b),
        ("factor_o", a * b),
        ("equal_o", a.equals(b)),
        ("less_o", a.less(b)),
        ("signed_o", a.less(b)),
        ("any_o", a.any()),
        ("all_o", a.all()),
        ("left_o", a.shift_left(by)),
        ("right_o", a.shift_right(by)),
        ("mux_o", s.mux(a, b)),
        ("concat_o", m.concat(&[a, b])),
        ("replicate_o", s.replicate(8)),
        ("slice_o", a.bits(5, 2)),
        ("bit_o", a.bit(3)),
        ("decimal_o", m.constant(8, 165)),
        ("hexadecimal_o", m.constant(32, 0x3f80_0000)),
        ("grouped_o", (a + b).shift_right(one)),
        ("alias_o", forward.wire()),
        ("right_sum_o", a + b),
    ] {
        m.output(name, wire);
    }
    forward.drive(b);
    m.finish().expect("a module")
}

/// A module with the ports of `lines` in, and the output `x_o`.
fn one(name: &str, build: impl for<'m> Fn(&'m Builder, [raypath_hdl::Wire<'m>; 3])) -> Arc<Module> {
    let m = Builder::new(name);
    build(&m, [m.input("a_i", 8), m.input("b_i", 8), m.input("s_i", 1)]);
    m.finish().expect("a module")
}

fn modules() -> Vec<Arc<Module>> {
    let label = || Label { name: "OpOne".to_string(), value: 1 };
    let inner = one("inner", |m, [a, b, s]| m.output("x_o", s.mux(a, a - b)));
    let register = |name: &'static str| {
        one(name, move |m, [a, b, s]| {
            let q = m.register("q_q", 8);
            if name == "held" {
                q.next_when(s, a)
            } else {
                q.next(a)
            }
            m.output("x_o", q.wire() ^ b);
        })
    };
    vec![
        one("label", move |m, [a, b, s]| m.output("x_o", m.case(s.extend(2), &[(label(), a)], b))),
        one("fallback", move |m, [a, b, s]| m.output("x_o", m.case(s.extend(2), &[(label(), a)], b))),
        register("held"),
        one("started", |m, [a, b, s]| {
            let q = m.register("q_q", 8).reset_to(3);
            q.next_when(s, a);
            m.output("x_o", q.wire() ^ b);
        }),
        register("clocked"),
        one("connected", move |m, [a, b, s]| {
            m.output("x_o", m.instance("u_inner", &inner, &[("a_i", a), ("b_i", b), ("s_i", s)])[0]);
        }),
        one("stored", |m, [a, b, s]| {
            let memory = m.memory("u_store", 4, &[("word", 8)]);
            memory.write(s, a.lower(2), &[a ^ b]);
            m.output("x_o", memory.read(!s, b.lower(2))[0]);
        }),
        register("right_state"),
    ]
}

fn top() -> Arc<Module> {
    let m = Builder::new("translations");
    let ports = [("a_i", m.input("a_i", 8)), ("b_i", m.input("b_i", 8)), ("s_i", m.input("s_i", 1))];
    let all = lines();
    for (port, wire) in all.outputs().iter().zip(m.instance("u_lines", &all, &ports)) {
        m.output(&port.name, wire);
    }
    for module in modules() {
        let name = module.name().to_string();
        m.output(&format!("{name}_o"), m.instance(&format!("u_{name}"), &module, &ports)[0]);
    }
    m.finish().expect("a module")
}

/// The text with all faults.
fn faulty(top: &Arc<Module>) -> String {
    let mut whole = verilog::text(top).expect("a text");
    let mut replace = |module: &str, from: &str, to: &str| {
        let start = whole.find(&format!("module {module} (")).expect("a module");
        let end = start + whole[start..].find("endmodule").expect("its end");
        let text = &whole[start..end];
        assert_eq!(text.matches(from).count(), 1, "'{from}' in\n{text}");
        let text = text.replace(from, to);
        whole.replace_range(start..end, &text);
    };
    let lines = verilog::print_module(&lines(), &[]).expect("a text");
    for (output, from, to) in IN_LINES {
        let line = lines.lines().find(|line| line.contains(&format!("assign {output} "))).expect("a line");
        assert!(line.contains(from), "'{from}' in {line}");
        replace("lines", line, &line.replace(from, to));
    }
    IN_MODULES.iter().for_each(|(module, from, to)| replace(module, from, to));
    whole
}

#[test]
fn every_wrong_translation_shows_in_verilator() {
    let top = top();
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("translations.sv");
    write(&file, &faulty(&top)).expect("a file");
    let verilated = Verilated::build_sources(&[file], &top, folder.path(), &Default::default()).expect("a model");
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut frame = |cycle: u32| {
        let a: u8 = random.random();
        // Some operands are equal.
        let b = if cycle.is_multiple_of(8) { a } else { random.random() };
        vec![u64::from(cycle % 16 != 1), a.into(), b.into(), random.random_range(0..2)]
    };
    let frames: Vec<Vec<u64>> = (0..400).map(&mut frame).collect();
    let mut simulator = Simulator::new(&top).expect("a simulator");
    let mut differs = vec![false; top.outputs().len()];
    verilated
        .run(frames.iter().cloned(), |cycle, outputs| {
            simulator.set_reset(frames[cycle][0] == 0);
            simulator.set_all(frames[cycle][1..].iter().copied());
            simulator.cycle();
            for ((differs, simulated), value) in differs.iter_mut().zip(simulator.outputs()).zip(outputs) {
                *differs |= simulated != value;
            }
        })
        .expect("a run");
    let shown: Vec<(&str, bool)> = top.outputs().iter().map(|port| port.name.as_str()).zip(differs).collect();
    let wrong: Vec<_> = shown.into_iter().filter(|(name, differs)| *differs == RIGHT.contains(name)).collect();
    assert!(wrong.is_empty(), "these outputs differ without a fault, or do not differ with one: {wrong:?}");
}
