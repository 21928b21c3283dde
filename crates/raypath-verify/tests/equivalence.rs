//! Equivalence checks of modules and changed ones: equivalent changes are proved, others are shown with values.

use raypath_hdl::{Builder, Label, Module};
use raypath_verify::Error;
use raypath_verify::equivalence::Equivalence;
use raypath_verify::sat::Prover;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Changes of a counter: faults, and `Rewritten`, which is equivalent.
#[derive(Clone, Copy, PartialEq)]
enum Change {
    None,
    Rewritten,
    Step,
    Enable,
    ResetValue,
    NoReset,
    Rare,
}

fn counter(change: Change) -> Arc<Module> {
    counter_named("counter", change)
}

/// Counts up by `step_i` while `en_i`.
fn counter_named(name: &str, change: Change) -> Arc<Module> {
    let m = Builder::new(name);
    let (step, en) = (m.input("step_i", 16), m.input("en_i", 1));
    let count = m.register("count_q", 16);
    let count = match change {
        Change::NoReset => count,
        Change::ResetValue => count.reset_to(6),
        _ => count.reset_to(7),
    };
    let next = match change {
        // a + b is (a ^ b) + 2 (a & b).
        Change::Rewritten => {
            let both = m.concat(&[(step & count.wire()).lower(15), m.constant(1, 0)]);
            (step ^ count.wire()) + both
        }
        Change::Step => step + count.wire() + m.constant(16, 1),
        Change::Rare => step.is(0x1234).mux(step, step + count.wire()),
        _ => step + count.wire(),
    };
    match change {
        Change::Enable => count.next(next),
        _ => count.next_when(en, next),
    }
    m.output("count_o", count.wire());
    m.finish().unwrap()
}

/// Two counters in a row; the second is changed.
fn row(change: Change) -> Arc<Module> {
    let m = Builder::new("row");
    let (step, en) = (m.input("step_i", 16), m.input("en_i", 1));
    // A name that the exposed register of the second counter would take.
    let second_count_q = (step ^ m.constant(16, 3)).named("second_count_q");
    let first = m.instance("u_first", &first(), &[("step_i", step), ("en_i", en)])[0];
    let second = m.instance("u_second", &counter_named("second", change), &[("step_i", first), ("en_i", en)])[0];
    m.output("count_o", second ^ second_count_q);
    m.finish().unwrap()
}

fn first() -> Arc<Module> {
    let m = Builder::new("first");
    let (step, en) = (m.input("step_i", 16), m.input("en_i", 1));
    m.output("count_o", m.instance("u_count", &counter(Change::None), &[("step_i", step), ("en_i", en)])[0]);
    m.finish().unwrap()
}

fn compare(pairs: &[(Arc<Module>, Arc<Module>)]) -> Result<Vec<Equivalence>, Error> {
    let pairs: Vec<(&Arc<Module>, &Arc<Module>)> = pairs.iter().map(|(a, b)| (a, b)).collect();
    Prover::find()?.equivalent(&pairs, Duration::from_secs(60), &AtomicBool::new(false))
}

#[test]
fn other_notations_of_a_value_are_equal() {
    let pairs = [Change::None, Change::Rewritten].map(|change| (counter(Change::None), counter(change)));
    assert_eq!(compare(&pairs).unwrap(), [Equivalence::Proved, Equivalence::Proved]);
}

#[test]
fn every_change_is_found() {
    let changes = [Change::Step, Change::Enable, Change::ResetValue, Change::NoReset, Change::Rare];
    let found = compare(&changes.map(|change| (counter(Change::None), counter(change)))).unwrap();
    for equivalence in &found {
        let Equivalence::Different(values) = equivalence else { panic!("{equivalence:?}") };
        let names: Vec<&str> = values.keys().map(String::as_str).collect();
        assert_eq!(names, ["count_q", "en_i", "step_i"]);
    }
    let Equivalence::Different(values) = &found[4] else { unreachable!() };
    assert_eq!((values["step_i"], values["en_i"]), (0x1234, 1));
    let Equivalence::Different(values) = &found[1] else { unreachable!() };
    assert_eq!(values["en_i"], 0);
}

#[test]
fn registers_inside_instances_count() {
    let changes = [Change::None, Change::Rewritten, Change::Step, Change::Rare];
    let found = compare(&changes.map(|change| (row(Change::None), row(change)))).unwrap();
    assert_eq!(found[..2], [Equivalence::Proved, Equivalence::Proved]);
    for equivalence in &found[2..] {
        let Equivalence::Different(values) = equivalence else { panic!("{equivalence:?}") };
        let names: Vec<&str> = values.keys().map(String::as_str).collect();
        assert_eq!(names, ["en_i", "first_count_count_q", "second_count_q_2", "step_i"]);
    }
}

/// Selects one of four inputs; `order` maps the select value to the input.
fn choice(order: [usize; 4]) -> Arc<Module> {
    let m = Builder::new("choice");
    let select = m.input("select_i", 2);
    let inputs = ["a_i", "b_i", "c_i", "d_i"].map(|name| m.input(name, 8));
    let labels = ["A", "B", "C", "D"].into_iter().zip(0..);
    let arms: Vec<_> = labels
        .zip(order)
        .map(|((name, value), index)| (Label { name: name.to_string(), value }, inputs[index]))
        .collect();
    m.output("chosen_o", m.case(select, &arms, inputs[3]));
    m.finish().unwrap()
}

/// Yosys replaced the default, which no value selects, by a free input, and the comparison was refused.
#[test]
fn a_case_over_all_values_has_no_free_input() {
    let pairs = [[0, 1, 2, 3], [0, 2, 1, 3]].map(|order| (choice([0, 1, 2, 3]), choice(order)));
    let found = compare(&pairs).unwrap();
    assert!(matches!(found[..], [Equivalence::Proved, Equivalence::Different(_)]), "{found:?}");
}

#[test]
fn other_ports_or_registers_are_an_error() {
    let m = Builder::new("counter");
    m.output("count_o", m.input("step_i", 16) ^ m.input("en_i", 1).extend(16));
    let error = compare(&[(counter(Change::None), m.finish().unwrap())]).unwrap_err().to_string();
    assert!(error.contains("module counter") && error.contains("count_q"), "{error}");
}
