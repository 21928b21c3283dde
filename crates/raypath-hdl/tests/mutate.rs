//! Faults: every kind of driver has faults, each changes the text and the simulation, and they can be put into a
//! hierarchy.

use raypath_hdl::mutate::{Fault, faults, replace};
use raypath_hdl::{Builder, Driver, Error, Label, Module, Simulator, verilog};
use std::collections::BTreeSet;
use std::sync::Arc;

/// A module with every kind of driver except instances, and all kinds of registers; all are observable.
fn everything() -> Arc<Module> {
    let m = Builder::new("everything");
    let (a, b, s) = (m.input("a_i", 4), m.input("b_i", 4), m.input("s_i", 1));
    m.output("and_o", a & b);
    m.output("or_o", a | b);
    m.output("xor_o", a ^ b);
    m.output("not_o", !a);
    m.output("add_o", a + b);
    m.output("sub_o", a - b);
    m.output("mul_o", a * b);
    m.output("equal_o", a.equals(b));
    m.output("less_o", a.less(b));
    m.output("any_o", a.any());
    m.output("all_o", a.all());
    m.output("left_o", a.shift_left(b));
    m.output("right_o", a.shift_right(b));
    m.output("mux_o", s.mux(a, b));
    let labels = [("ONE", 1), ("TWO", 2)].map(|(name, value)| Label { name: name.to_string(), value });
    let [one, two] = labels;
    m.output("case_o", m.case(b, &[(one, a), (two, !a)], b));
    m.output("concat_o", m.concat(&[a, b, s]));
    m.output("slice_o", a.bits(2, 1));
    let forward = m.forward("second_name", 4);
    m.output("second_o", forward.wire());
    forward.drive(b);
    m.output("constant_o", m.constant(4, 5));
    let count = m.register("count_q", 4).reset_to(3);
    count.next_when(s, a);
    m.output("count_o", count.wire());
    let data = m.register("data_q", 4);
    data.next(b);
    m.output("data_o", data.wire());
    m.unused("unused_sum", &[(a + b).named("sum")]);
    m.finish().expect("a module")
}

#[test]
fn every_kind_of_driver_has_its_faults() {
    let texts: BTreeSet<String> = faults(&everything()).iter().map(Fault::to_string).collect();
    let found = |place: &str, what: &str| {
        texts
            .iter()
            .any(|text| text.contains(&format!(" in {place}: {what}")) || text.contains(&format!(", {place}: {what}")))
    };
    for (place, what) in [
        ("and_o", "And becomes Or"),
        ("and_o", "a_i replaced by zero"),
        ("or_o", "Or becomes And"),
        ("xor_o", "Xor becomes Or"),
        ("not_o", "Not left out"),
        ("add_o", "Add becomes Sub"),
        ("sub_o", "Sub becomes Add"),
        ("mul_o", "b_i replaced by zero"),
        ("equal_o", "inverted"),
        ("less_o", "operands of Less exchanged"),
        ("any_o", "Any becomes All"),
        ("all_o", "All becomes Any"),
        ("and_o", "a_i stuck at 1"),
        ("sub_o", "reads"),
        ("left_o", "shifts by one more"),
        ("right_o", "shifts by one more"),
        ("left_o", "shifts right"),
        ("right_o", "shifts left"),
        ("mux_o", "s_i inverted"),
        ("mux_o", "select stuck at 1"),
        ("mux_o", "select stuck at 0"),
        ("case_o", "an arm exchanged with the next"),
        ("case_o", "an arm left out"),
        ("case_o", "the first arm taken by default"),
        ("concat_o", "two parts of Concat exchanged"),
        ("slice_o", "slice one bit lower"),
        ("slice_o", "slice one bit higher"),
        ("second_name", "inverted"),
        ("constant_o", "constant one more"),
        ("constant_o", "constant one less"),
        ("constant_o", "top bit of the constant flipped"),
        ("count_q", "loads in every cycle"),
        ("count_q", "never loads"),
        ("count_q", "resets to 2 instead of 3"),
        ("count_q", "resets to 12 instead of 3"),
        ("data_q", "never loads"),
    ] {
        assert!(found(place, what), "{place}: {what}\n{texts:#?}");
    }
    assert!(texts.iter().all(|text| !text.contains("sum")), "nothing depends on it: {texts:#?}");
}

/// A memory with two columns of a width, one of another, and everything at ports.
fn store() -> Arc<Module> {
    let m = Builder::new("store");
    let input = |name: &str, width: u32| m.input(name, width);
    let (write, at) = (input("write_i", 1), input("at_i", 2));
    let word = [input("a_i", 4), input("b_i", 4), input("c_i", 1)];
    let (read, from) = (input("read_i", 1), input("from_i", 2));
    let memory = m.memory("u_store", 4, &[("a", 4), ("b", 4), ("c", 1)]);
    memory.write(write, at, &word);
    for (name, wire) in ["a_o", "b_o", "c_o"].into_iter().zip(memory.read(read, from)) {
        m.output(name, wire);
    }
    m.finish().expect("a memory")
}

#[test]
fn memories_have_their_faults() {
    let module = store();
    let found: BTreeSet<String> = faults(&module).iter().map(Fault::to_string).collect();
    let of_memory: BTreeSet<String> = [
        "write_enable: replaced by zero",
        "write_enable: stuck at 1",
        "write_address: bit 0 stuck at 0",
        "write_address: bit 1 stuck at 0",
        "write_address: exchanged with read_address",
        "read_enable: replaced by zero",
        "read_enable: stuck at 1",
        "read_address: bit 0 stuck at 0",
        "read_address: bit 1 stuck at 0",
        "write_a: replaced by zero",
        "write_a: exchanged with write_b",
        "write_b: replaced by zero",
        "write_c: replaced by zero",
    ]
    .map(|fault| format!("store, u_store.{fault}"))
    .into();
    assert_eq!(found.iter().filter(|fault| fault.contains(", u_store.")).cloned().collect::<BTreeSet<_>>(), of_memory);
    // Each has a text of its own, and a random test finds it.
    let shown = |module: &Arc<Module>| {
        let mut simulator = Simulator::new(module).expect("a simulator");
        let mut state = 1u64;
        let mut shown = Vec::new();
        for _ in 0..500 {
            simulator.set_all(std::iter::repeat_with(|| {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                state >> 40
            }));
            simulator.cycle();
            shown.extend_from_slice(simulator.outputs());
        }
        shown
    };
    let good = shown(&module);
    let mut texts = BTreeSet::from([verilog::text(&module).expect("a text")]);
    for fault in faults(&module) {
        let faulty = Arc::new(fault.apply(&module).expect("a faulty module"));
        assert!(texts.insert(verilog::text(&faulty).expect("a text")), "{fault}: the text of another one");
        assert_ne!(shown(&faulty), good, "{fault}");
    }
}

/// The text of a module, and its outputs for every input.
fn behaviour(module: &Arc<Module>) -> (String, Vec<u64>) {
    let mut simulator = Simulator::new(module).expect("a simulator");
    let mut shown = Vec::new();
    for number in 0..1_u64 << 9 {
        simulator.set_all([0, 4, 8].map(|low| number >> low));
        simulator.cycle();
        shown.extend_from_slice(simulator.outputs());
    }
    (verilog::print_module(module, &[]).expect("a text"), shown)
}

#[test]
fn every_fault_of_a_module_shows_in_its_text_and_in_what_it_does() {
    let module = everything();
    let good = behaviour(&module);
    let faults = faults(&module);
    let mut texts = BTreeSet::from([good.0.clone()]);
    for fault in &faults {
        let (text, shown) = behaviour(&Arc::new(fault.apply(&module).expect("a faulty module")));
        assert!(texts.insert(text), "{fault}: the text of another one");
        assert_ne!(shown, good.1, "{fault}");
    }
    assert!(faults.len() > 50, "{}", faults.len());
}

/// `outer` has two instances of `middle`, which has one of `inner`, and an instance of `other`.
fn hierarchy() -> (Arc<Module>, Arc<Module>) {
    let m = Builder::new("inner");
    m.output("x_o", m.input("x_i", 4) + m.constant(4, 1));
    let inner = m.finish().expect("inner");
    let m = Builder::new("middle");
    m.output("x_o", m.instance("u_inner", &inner, &[("x_i", m.input("x_i", 4))])[0]);
    let middle = m.finish().expect("middle");
    let m = Builder::new("other");
    m.output("x_o", !m.input("x_i", 4));
    let other = m.finish().expect("other");
    let m = Builder::new("outer");
    let mut x = m.input("x_i", 4);
    for (name, module) in [("u_first", &middle), ("u_other", &other), ("u_second", &middle)] {
        x = m.instance(name, module, &[("x_i", x)])[0];
    }
    m.output("x_o", x);
    (m.finish().expect("outer"), inner)
}

#[test]
fn a_faulty_module_replaces_the_original_in_every_instance() {
    let (outer, inner) = hierarchy();
    let fault =
        faults(&inner).into_iter().find(|fault| fault.to_string().contains("Add becomes Sub")).expect("a fault");
    let faulty = replace(&outer, &Arc::new(fault.apply(&inner).expect("a faulty module"))).expect("a hierarchy");
    let answer = |module: &Arc<Module>| Simulator::new(module).expect("a simulator").evaluate([5])[0];
    assert_eq!((answer(&outer), answer(&faulty)), ((!6 & 15) + 1, (!4 & 15) - 1));
    let instances = |module: &Module, index: usize| module.instances()[index].module.clone();
    assert!(Arc::ptr_eq(&instances(&outer, 1), &instances(&faulty, 1)), "what has not changed stays shared");
    assert!(Arc::ptr_eq(&instances(&faulty, 0), &instances(&faulty, 2)), "what was shared stays shared");
    verilog::modules(&faulty).expect("one text for each name");
}

#[test]
fn ports_of_instances_can_be_stuck() {
    let (outer, _) = hierarchy();
    let texts: Vec<String> = faults(&outer).iter().map(Fault::to_string).collect();
    let at = |name: &str| ["replaced by zero", "stuck at 1"].map(|how| format!("outer, {name}.x_i: {how}"));
    assert_eq!(texts, ["u_first", "u_other", "u_second"].map(at).concat());
    for fault in faults(&outer) {
        let faulty = Arc::new(fault.apply(&outer).expect("a faulty module"));
        assert_ne!(behaviour(&faulty), behaviour(&outer), "{fault}");
    }
}

#[test]
fn a_fault_of_another_module_is_refused() {
    let (outer, inner) = hierarchy();
    let fault = &faults(&inner)[0];
    assert!(matches!(fault.apply(&outer), Err(Error::Name { name, .. }) if name == "outer"));
    let m = Builder::new("inner");
    m.output("x_o", m.input("x_i", 4));
    let changed = m.finish().expect("another one");
    for fault in faults(&inner) {
        let refused = fault.apply(&changed).expect_err("there is nothing to change");
        assert!(refused.to_string().contains("is not what it was"), "{refused}");
    }
}

#[test]
fn a_replacement_that_does_not_fit_is_refused() {
    let (outer, _) = hierarchy();
    let module = |name: &str, width| {
        let m = Builder::new(name);
        m.output("x_o", m.input("x_i", width));
        m.finish().expect("a module")
    };
    let refused = |module| replace(&outer, &module).expect_err("it does not fit").to_string();
    assert_eq!(
        refused(module("inner", 5)),
        "module inner: name 'inner' has other ports than the module that it replaces"
    );
    assert_eq!(refused(module("absent", 4)), "module outer: name 'absent' is the name of no module in it");
    replace(&outer, &module("inner", 4)).expect("it fits");
}

/// The first test lists all kinds of drivers: a new kind needs faults too.
#[test]
fn the_example_has_every_driver() {
    let kind = |driver: &Driver| format!("{driver:?}").split(['(', ' ']).next().unwrap_or_default().to_string();
    let kinds: BTreeSet<String> = everything().signals().iter().map(|signal| kind(&signal.driver)).collect();
    assert_eq!(kinds.len(), 21, "{kinds:?}");
}
