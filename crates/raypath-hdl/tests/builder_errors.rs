//! The errors of `Builder`: each names the module, the signal and the problem.

use raypath_hdl::{Builder, Error, Label, Wire};

/// The error of building a module `bad` with inputs `a_i` of 8 bits and `c_i` of 1 bit.
fn error_of(describe: impl FnOnce(&Builder)) -> Error {
    let m = Builder::new("bad");
    describe(&m);
    m.finish().expect_err("accepted")
}

fn rejects(expected: Error, describe: impl FnOnce(&Builder)) {
    assert_eq!(error_of(describe), expected);
}

fn width(signal: &str, problem: &str) -> Error {
    Error::Width { module: "bad".into(), signal: signal.into(), problem: problem.into() }
}

fn name(name: &str, problem: &str) -> Error {
    Error::Name { module: "bad".into(), name: name.into(), problem: problem.into() }
}

fn drive(signal: &str, problem: &str) -> Error {
    Error::Drive { module: "bad".into(), signal: signal.into(), problem: problem.into() }
}

const NO_IDENTIFIER: &str = "is not an identifier: letters, digits and underscores, no digit first";

#[test]
fn operands_of_unequal_width() {
    macro_rules! rejects {
        ($operator:literal, $a:ident, $b:ident, $expression:expr) => {
            let found = error_of(|m| {
                let ($a, $b) = (m.input("a_i", 8), m.input("b_i", 7));
                let _ = $expression;
            });
            assert_eq!(found, width(concat!($operator, " 2"), "operand of 7 bits, expected 8"));
        };
    }
    rejects!("Add", a, b, a + b);
    rejects!("Sub", a, b, a - b);
    rejects!("And", a, b, a & b);
    rejects!("Or", a, b, a | b);
    rejects!("Xor", a, b, a ^ b);
    rejects!("Equal", a, b, a.equals(b));
    rejects!("Less", a, b, a.less(b));
}

#[test]
fn multiplexers_that_do_not_fit() {
    rejects(width("Mux 3", "operand of 7 bits, expected 8"), |m| {
        let (a, b) = (m.input("a_i", 8), m.input("b_i", 7));
        m.input("c_i", 1).mux(a, b);
    });
    rejects(width("Mux 1", "operand of 8 bits, expected 1"), |m| {
        let a = m.input("a_i", 8);
        a.mux(a, a);
    });
}

#[test]
fn cases_that_do_not_fit() {
    let label = |name: &str, value| Label { name: name.to_string(), value };
    rejects(width("Case 2", "label Four does not fit the selector"), |m| {
        let (a, b) = (m.input("a_i", 2), m.input("b_i", 7));
        m.case(a, &[(label("One", 1), b), (label("Four", 4), b)], b);
    });
    rejects(width("Case 2", "label Uno appears twice"), |m| {
        let (a, b) = (m.input("a_i", 2), m.input("b_i", 7));
        m.case(a, &[(label("One", 1), b), (label("Uno", 1), b)], b);
    });
    rejects(width("Case 2", "operand of 2 bits, expected 7"), |m| {
        let (a, b) = (m.input("a_i", 2), m.input("b_i", 7));
        m.case(a, &[(label("One", 1), a)], b);
    });
}

#[test]
fn widths_out_of_range() {
    let found = error_of(|m| _ = m.input("a_i", 0));
    assert!(matches!(&found, Error::Width { problem, .. } if problem == "width 0, expected 1 to 64"), "{found}");
    rejects(width("Concat 2", "width 65, expected 1 to 64"), |m| {
        let a = m.input("a_i", 64);
        m.concat(&[a, a.top()]);
    });
    rejects(width("Mul 1", "width 66, expected 1 to 64"), |m| {
        let a = m.input("a_i", 33);
        let _ = a * a;
    });
    assert_eq!(error_of(|m| _ = m.concat(&[])), width("Concat 0", "width 0, expected 1 to 64"));
}

#[test]
fn constants_and_reset_values_that_do_not_fit() {
    assert_eq!(error_of(|m| _ = m.constant(3, 8)), width("Constant 0", "constant 8 does not fit 3 bits"));
    rejects(width("count_q", "reset value 8 does not fit"), |m| {
        let count = m.register("count_q", 3).reset_to(8);
        count.next(count.wire());
    });
}

#[test]
fn cuts_and_extensions_that_do_not_fit() {
    type Cut = fn(Wire<'_>) -> Wire<'_>;
    let cases: [(Cut, &str); 9] = [
        (|a| a.bits(u32::MAX, 0), "bits [4294967295:0] of 8"),
        (|a| a.bits(8, 0), "bits [8:0] of 8"),
        (|a| a.bits(2, 3), "bits [2:3] of 8"),
        (|a| a.bit(8), "bits [8:8] of 8"),
        (|a| a.lower(9), "bits [8:0] of 8"),
        (|a| a.lower(0), "no lower bits"),
        (|a| a.upper(9), "9 upper bits of 8"),
        (|a| a.upper(0), "0 upper bits of 8"),
        (|a| a.extend(7), "8 bits extended to 7"),
    ];
    for (cut, problem) in cases {
        assert_eq!(error_of(|m| _ = cut(m.input("a_i", 8))), width("a_i", problem));
    }
}

#[test]
fn shift_amounts_that_are_too_wide() {
    rejects(width("ShiftLeft 2", "shift amount of 33 bits, expected 1 to 32"), |m| {
        _ = m.input("a_i", 8).shift_left(m.input("b_i", 33))
    });
    rejects(width("ShiftRight 2", "shift amount of 64 bits, expected 1 to 32"), |m| {
        _ = m.input("a_i", 8).shift_right(m.input("b_i", 64))
    });
}

#[test]
fn wires_of_another_module() {
    let other = Builder::new("other");
    let strange = [other.input("x_i", 4), other.input("strange_i", 1)][1];
    let taker = {
        let m = Builder::new("taker");
        m.unused("unused_a", &[m.input("a_i", 1)]);
        m.finish().unwrap()
    };
    let label = || Label { name: "One".to_string(), value: 1 };
    macro_rules! refused {
        ($(|$m:ident, $a:ident| $use:expr;)*) => {$({
            let $m = Builder::new("bad");
            let $a = $m.input("a_i", 1);
            let _ = ($a, $use);
            let found = $m.finish().expect_err("accepted");
            assert_eq!(found, drive("strange_i", "belongs to another module"), stringify!($use));
        })*};
    }
    refused! {
        |m, a| a + strange;
        |m, a| a - strange;
        |m, a| a * strange;
        |m, a| a & strange;
        |m, a| a | strange;
        |m, a| a ^ strange;
        |m, a| a.equals(strange);
        |m, a| a.less(strange);
        |m, a| a.shift_left(strange);
        |m, a| a.shift_right(strange);
        |m, a| a.mux(strange, a);
        |m, a| a.mux(a, strange);
        |m, a| m.concat(&[strange]);
        |m, a| m.concat(&[a, strange]);
        |m, a| m.case(strange, &[(label(), a)], a);
        |m, a| m.case(a, &[(label(), strange)], a);
        |m, a| m.case(a, &[(label(), a)], strange);
        |m, a| m.output("b_o", strange);
        |m, a| m.unused("unused_b", &[strange]);
        |m, a| m.instance("u_taker", &taker, &[("a_i", strange)]);
        |m, a| m.register("b_q", 1).next(strange);
        |m, a| m.register("b_q", 1).next_when(strange, a);
        |m, a| m.register("b_q", 1).next_when(a, strange);
        |m, a| m.forward("b", 1).drive(strange);
    };
    // A module without signals rejects it too.
    let m = Builder::new("bad");
    m.output("b_o", strange);
    assert_eq!(m.finish().expect_err("accepted"), drive("strange_i", "belongs to another module"));
}

#[test]
fn labels_that_cannot_be() {
    let with = |labels: [(&str, u64); 2]| {
        let m = Builder::new("bad");
        let (select, a) = (m.input("select_i", 2), m.input("a_i", 1));
        for (n, (name, value)) in labels.into_iter().enumerate() {
            let label = Label { name: name.to_string(), value };
            m.output(&format!("x{n}_o"), m.case(select, &[(label, a)], !a));
        }
        m.finish().map(|_| ())
    };
    assert_eq!(with([("OpOne", 1), ("OpOne", 1)]), Ok(()));
    assert_eq!(with([("OpOne", 1), ("OpOne", 2)]), Err(name("OpOne", "labels both 2'd1 and 2'd2")));
    assert_eq!(with([("OpOne", 1), ("a_i", 2)]), Err(name("a_i", "is taken")));
    assert_eq!(with([("OpOne", 1), ("case", 2)]), Err(name("case", "is a keyword of SystemVerilog")));
    rejects(name("One", "labels both 1'd1 and 2'd1"), |m| {
        let a = m.input("a_i", 1);
        m.case(a, &[(Label { name: "One".to_string(), value: 1 }, a)], a);
        m.case(m.concat(&[a, a]), &[(Label { name: "One".to_string(), value: 1 }, a)], a);
    });
    rejects(name("One", "is taken"), |m| {
        let a = m.input("a_i", 1);
        m.case(a, &[(Label { name: "One".to_string(), value: 1 }, a)], a).named("One");
    });
}

#[test]
fn registers_and_forwards_of_another_width() {
    rejects(width("count_q", "operand of 8 bits, expected 4"), |m| m.register("count_q", 4).next(m.input("a_i", 8)));
    rejects(width("count_q", "operand of 4 bits, expected 1"), |m| {
        let a = m.input("a_i", 4);
        m.register("count_q", 4).next_when(a, a);
    });
    rejects(width("later", "operand of 8 bits, expected 4"), |m| m.forward("later", 4).drive(m.input("a_i", 8)));
    assert_eq!(error_of(|m| _ = m.input("a_i", 8).replicate(2)), width("a_i", "operand of 8 bits, expected 1"));
    rejects(width("a_i", "4294967295 copies, expected 1 to 64"), |m| _ = m.input("a_i", 1).replicate(u32::MAX));
}

#[test]
fn signals_without_a_driver_or_with_two() {
    assert_eq!(error_of(|m| _ = m.register("count_q", 4)), drive("count_q", "is never driven"));
    assert_eq!(error_of(|m| _ = m.forward("later", 4)), drive("later", "is never driven"));
    rejects(drive("count_q", "is driven twice"), |m| {
        let count = m.register("count_q", 4);
        count.next(count.wire());
        count.next(count.wire());
    });
    rejects(drive("later", "is driven twice"), |m| {
        let (a, later) = (m.input("a_i", 4), m.forward("later", 4));
        later.drive(a);
        later.drive(a);
    });
}

#[test]
fn names_that_cannot_be() {
    for (bad, problem) in [
        ("2nd", NO_IDENTIFIER),
        ("", NO_IDENTIFIER),
        ("a.b", NO_IDENTIFIER),
        ("größe", NO_IDENTIFIER),
        ("wire", "is a keyword of SystemVerilog"),
        ("double", "is a keyword of C++, which Verilator refuses"),
        ("switch", "is a keyword of C++, which Verilator refuses"),
        ("far", "is a common word of C++, which Verilator warns about"),
        ("sum__out", "has two underscores in a row, which Verilator keeps for itself"),
        ("clk_i", "is taken"),
        ("rst_ni", "is taken"),
        ("a_i", "is taken"),
    ] {
        let declare: [fn(&Builder, &str); 6] = [
            |m, name| _ = m.input(name, 1),
            |m, name| m.output(name, m.constant(1, 0)),
            |m, name| {
                let register = m.register(name, 1);
                register.next(register.wire());
            },
            |m, name| m.forward(name, 1).drive(m.constant(1, 0)),
            |m, name| _ = m.constant(1, 0).named(name),
            |m, name| _ = m.instance(name, &Builder::new("empty").finish().unwrap(), &[]),
        ];
        for declare in declare {
            let found = error_of(|m| {
                m.input("a_i", 8);
                declare(m, bad);
            });
            assert_eq!(found, name(bad, problem));
        }
    }
    let found = Builder::new("module").finish().expect_err("accepted");
    let problem = "is a keyword of SystemVerilog".to_string();
    assert_eq!(found, Error::Name { module: "module".into(), name: "module".into(), problem });
}

#[test]
fn instances_whose_ports_do_not_match() {
    let inner = {
        let m = Builder::new("inner");
        let a = m.input("a_i", 8);
        m.output("a_o", a);
        m.finish().unwrap()
    };
    let connected = |ports: &[(&str, u32)]| {
        error_of(|m| {
            let inputs: Vec<_> =
                ports.iter().map(|&(port, width)| (port, m.input(&format!("x_{port}"), width))).collect();
            m.instance("u_inner", &inner, &inputs);
        })
    };
    let twice = error_of(|m| {
        let (a, b) = (m.input("a_i", 8), m.input("b_i", 8));
        m.instance("u_inner", &inner, &[("a_i", a), ("a_i", b)]);
    });
    assert_eq!(twice, drive("u_inner.a_i", "is driven twice"));
    assert_eq!(connected(&[]), drive("u_inner.a_i", "is never driven"));
    assert_eq!(connected(&[("a_i", 7)]), width("u_inner.a_i", "connected to 7 bits, expected 8"));
    assert_eq!(connected(&[("a_i", 8), ("b_i", 8)]), name("b_i", "is not an input of inner"));
}

/// The text prints 64 bits as `Width` there.
#[test]
fn only_the_payload_has_the_width_of_the_payload() {
    let error = error_of(|m| {
        m.parameterise_width();
        m.output("data_o", m.input("data_i", 64));
        m.output("write_o", m.input("write_i", 64));
    });
    assert_eq!(error, width("write_i", "64 bits stand for the parameter Width, expected fewer"));
}

#[test]
fn unused_signals_are_declared_as_such() {
    assert_eq!(error_of(|m| m.unused("rest", &[m.input("a_i", 8)])), name("rest", "must begin with unused_"));
}

/// The first error is reported.
#[test]
fn the_first_error_is_kept() {
    rejects(width("Constant 0", "constant 8 does not fit 3 bits"), |m| {
        m.constant(3, 8);
        m.input("wire", 1);
    });
}

#[test]
fn messages_name_module_and_signal() {
    let message = width("sum", "operand of 7 bits, expected 8").to_string();
    assert_eq!(message, "module bad, signal sum: operand of 7 bits, expected 8");
    let message = drive("later", "is never driven").to_string();
    assert_eq!(message, "module bad: 'later' is never driven");
    let message = Error::Loop(["a", "b", "a"].map(String::from).to_vec()).to_string();
    assert_eq!(message, "combinational loop through a -> b -> a");
}
