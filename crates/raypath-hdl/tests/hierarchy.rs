//! Instances: names, observation, paths against the order of instances, loops.

use raypath_hdl::{Builder, Error, Module, Simulator, depends_combinationally, influences};
use std::sync::Arc;

/// A register between a valid/ready pair on each side, ready passing through combinationally.
fn stage() -> Arc<Module> {
    let m = Builder::new("stage");
    let (valid, data, ready) = (m.input("valid_i", 1), m.input("data_i", 8), m.input("ready_i", 1));
    let (valid_q, data_q) = (m.register("valid_q", 1).reset_to(0), m.register("data_q", 8));
    let free = (!valid_q.wire() | ready).named("free");
    valid_q.next_when(free, valid);
    data_q.next_when(free & valid, data + m.constant(8, 1));
    m.output("ready_o", free);
    m.output("valid_o", valid_q.wire());
    m.output("data_o", data_q.wire());
    m.finish().unwrap()
}

/// Two instances of `stage`, one after the other: the ready of the second goes back into the first.
fn pair(name: &str, stage: &Arc<Module>, instances: [&str; 2]) -> Arc<Module> {
    let m = Builder::new(name);
    let (valid, data, ready) = (m.input("valid_i", 1), m.input("data_i", 8), m.input("ready_i", 1));
    let back = m.forward("back", 1);
    let first = [("valid_i", valid), ("data_i", data), ("ready_i", back.wire())];
    let first = m.instance(instances[0], stage, &first);
    let second = [("valid_i", first[1]), ("data_i", first[2]), ("ready_i", ready)];
    let second = m.instance(instances[1], stage, &second);
    back.drive(second[0]);
    for (name, wire) in [("ready_o", first[0]), ("valid_o", second[1]), ("data_o", second[2])] {
        m.output(name, wire);
    }
    m.finish().unwrap()
}

/// Stages are nested two deep.
fn four_stages() -> Arc<Module> {
    pair("four", &pair("two", &stage(), ["u_a", "u_b"]), ["u_near", "u_far"])
}

#[test]
fn a_forward_wire_is_no_constant_before_it_is_driven() {
    let m = Builder::new("inverted");
    let a = m.input("a_i", 4);
    let later = m.forward("later", 4);
    m.output("inverted_o", !later.wire());
    m.output("bit_o", later.wire().bit(2));
    later.drive(a);
    let module = m.finish().expect("a module");
    let mut simulator = Simulator::new(&module).expect("a simulator");
    for value in 0..16 {
        assert_eq!(simulator.evaluate([value]), [!value & 15, value >> 2 & 1]);
    }
}

#[test]
fn nested_stages_move_data_and_stop_together() {
    let mut s = Simulator::new(&four_stages()).unwrap();
    let [valid, data, ready] = ["valid_i", "data_i", "ready_i"].map(|name| s.input(name).unwrap());
    let [ready_o, valid_o, data_o] = ["ready_o", "valid_o", "data_o"].map(|name| s.output(name).unwrap());
    s.set(valid, 1);
    let mut sent = 0;
    for _ in 0..10 {
        s.set(data, 100 + sent);
        s.cycle();
        sent += s.get(ready_o);
    }
    assert_eq!(sent, 4, "four stages hold four values");
    s.set(ready, 1);
    for taken in 0..20 {
        s.set(data, 100 + sent);
        s.cycle();
        assert_eq!(s.get(valid_o), 1);
        assert_eq!(s.get(data_o), 100 + taken + 4, "each of four stages adds one");
        sent += s.get(ready_o);
    }
    assert_eq!(sent, 24, "ready reached the entrance within the cycle");
}

#[test]
fn a_ready_that_runs_backwards_is_no_loop() {
    let four = four_stages();
    assert_eq!(depends_combinationally(&four, "ready_o", "ready_i"), Ok(true));
    assert_eq!(depends_combinationally(&four, "ready_o", "valid_i"), Ok(false));
    assert_eq!(depends_combinationally(&four, "data_o", "data_i"), Ok(false));
    assert_eq!(depends_combinationally(&stage(), "ready_o", "ready_i"), Ok(true));
    // Through registers.
    assert_eq!(influences(&four, &["ready_o", "valid_o"]), Ok(vec!["valid_i", "ready_i"]));
    assert_eq!(influences(&four, &["data_o"]), Ok(vec!["valid_i", "data_i", "ready_i"]));
    assert!(influences(&four, &["other_o"]).is_err());
}

/// Two independent paths, long enough to be compiled as a function that is called.
fn crossing() -> Arc<Module> {
    let m = Builder::new("crossing");
    let (mut east, mut west) = (m.input("east_i", 8), m.input("west_i", 8));
    for step in 1..30 {
        east = east + m.constant(8, step);
        west = west ^ m.constant(8, step);
    }
    m.output("east_o", east);
    m.output("west_o", west);
    m.finish().unwrap()
}

#[test]
fn paths_in_both_directions_through_large_modules_are_no_loop() {
    let crossing = crossing();
    let m = Builder::new("there_and_back");
    let (east, west) = (m.input("east_i", 8), m.input("west_i", 8));
    let back = m.forward("back", 8);
    let first = m.instance("u_a", &crossing, &[("east_i", east), ("west_i", back.wire())]);
    let second = m.instance("u_b", &crossing, &[("east_i", first[0]), ("west_i", west)]);
    back.drive(second[1]);
    m.output("east_o", second[0]);
    m.output("west_o", first[1]);
    let module = m.finish().unwrap();
    assert_eq!(depends_combinationally(&module, "east_o", "east_i"), Ok(true));
    assert_eq!(depends_combinationally(&module, "east_o", "west_i"), Ok(false));

    let mut s = Simulator::new(&module).unwrap();
    let sum: u64 = (1..30).sum();
    assert_eq!(s.evaluate([7, 0x55]), [(7 + 2 * sum) % 256, 0x55], "to the west the same bits twice flipped");
}

#[test]
fn a_loop_is_an_error_that_names_its_signals() {
    let m = Builder::new("ring");
    let a = m.input("a_i", 4);
    let later = m.forward("later", 4);
    let sum = (later.wire() + a).named("sum");
    later.drive(sum);
    m.output("sum_o", a);
    let ring = m.finish().unwrap();
    let expected = Err(Error::Loop(["later", "sum", "later"].map(String::from).to_vec()));
    assert_eq!(Simulator::new(&ring).map(|_| ()), expected, "though no output needs it");
    assert_eq!(depends_combinationally(&ring, "sum_o", "a_i").map(|_| ()), expected);
}

#[test]
fn a_loop_through_instances_is_named_with_their_paths() {
    let crossing = crossing();
    let m = Builder::new("closed");
    let a = m.input("a_i", 8);
    let later = m.forward("later", 8);
    let first = m.instance("u_a", &crossing, &[("east_i", later.wire()), ("west_i", a)]);
    let second = m.instance("u_b", &crossing, &[("east_i", first[0]), ("west_i", a)]);
    later.drive(second[0]);
    m.output("a_o", second[1]);
    let Err(Error::Loop(mut names)) = Simulator::new(&m.finish().unwrap()).map(|_| ()) else {
        panic!("a loop was not found");
    };
    assert_eq!(names.first(), names.last());
    names.pop();
    let start = names.iter().position(|name| name == "later").expect("the forward wire is on the loop");
    names.rotate_left(start);
    assert_eq!(names, ["later", "u_a.east_i", "a_east", "u_b.east_i", "b_east"]);
}

#[test]
fn a_loop_inside_an_instance_has_the_instances_path() {
    let m = Builder::new("ring");
    let mut value = m.input("a_i", 4);
    let later = m.forward("later", 4);
    for _ in 0..30 {
        value = value + later.wire();
    }
    later.drive(value);
    m.output("value_o", value);
    let ring = m.finish().unwrap();
    let m = Builder::new("outer");
    let a = m.input("a_i", 4);
    m.output("value_o", m.instance("u_ring", &ring, &[("a_i", a)])[0]);
    let found = Simulator::new(&m.finish().unwrap()).map(|_| ());
    assert_eq!(found, Err(Error::Loop(["u_ring.later", "u_ring.later"].map(String::from).to_vec())));
}

#[test]
fn deep_chains_do_not_exhaust_the_stack() {
    let m = Builder::new("deep");
    let a = m.input("a_i", 8);
    let mut wire = a;
    for _ in 0..100_000 {
        wire = wire + a;
    }
    m.output("a_o", wire);
    let module = m.finish().unwrap();
    assert_eq!(depends_combinationally(&module, "a_o", "a_i"), Ok(true));
}

#[test]
fn observed_signals_have_hierarchical_names() {
    let four = four_stages();
    let wanted = ["u_near.u_a.data_q", "u_far.u_b.free", "u_far.data_o", "data_i"];
    let mut s = Simulator::observing(&four, |name| wanted.contains(&name)).unwrap();
    let mut found: Vec<_> = s.signals().collect();
    found.sort();
    assert_eq!(found, [("data_i", 8), ("u_far.data_o", 8), ("u_far.u_b.free", 1), ("u_near.u_a.data_q", 8)]);

    let (valid, data) = (s.input("valid_i").unwrap(), s.input("data_i").unwrap());
    let [near, free, out, input] = wanted.map(|name| s.observe(name).unwrap());
    s.set(valid, 1);
    for cycle in 0..6 {
        s.set(data, 10 + cycle);
        s.cycle();
        assert_eq!(s.peek(input), 10 + cycle);
        assert_eq!(s.peek(near), [0, 11, 12, 13, 14, 14][cycle as usize]);
        assert_eq!(s.peek(free), u64::from(cycle < 4), "full from cycle {cycle}");
        assert_eq!(s.peek(out), if cycle < 4 { 0 } else { 14 });
    }
    let all = Simulator::observing(&four, |_| true).unwrap();
    for name in ["back", "ready_o", "u_near.back", "u_near.u_b.ready_i", "u_far.a_valid", "u_far.u_a.valid_q"] {
        assert!(all.observe(name).is_ok(), "{name}");
    }
}

#[test]
fn signals_inside_called_modules_can_be_observed() {
    let m = Builder::new("lengthy");
    let mut value = m.input("a_i", 8);
    for _ in 0..30 {
        value = value + m.constant(8, 1);
    }
    m.output("a_o", value.named("last"));
    let lengthy = m.finish().unwrap();
    let m = Builder::new("outer");
    let a = m.input("a_i", 8);
    for n in 0..3 {
        let wire = m.instance(&format!("u_p{n}"), &lengthy, &[("a_i", a + m.constant(8, n))])[0];
        m.output(&format!("a{n}_o"), wire);
    }
    let mut s = Simulator::observing(&m.finish().unwrap(), |name| name == "u_p1.last").unwrap();
    assert_eq!(s.evaluate([5]), [35, 36, 37]);
    assert_eq!(s.peek(s.observe("u_p1.last").unwrap()), 36);
}

#[test]
fn unknown_names_are_errors() {
    let s = Simulator::observing(&four_stages(), |name| name == "u_near.back").unwrap();
    let name_error = |problem: &str, name: &str| Error::Name {
        module: "four".to_string(),
        name: name.to_string(),
        problem: problem.to_string(),
    };
    assert_eq!(s.input("data_o"), Err(name_error("is not an input of it", "data_o")));
    assert_eq!(s.output("data_i"), Err(name_error("is not an output of it", "data_i")));
    assert_eq!(s.observe("back"), Err(name_error("is not an observed signal", "back")));
    assert_eq!(depends_combinationally(s.module(), "no", "data_i"), Err(name_error("is not an output of it", "no")));
    assert_eq!(depends_combinationally(s.module(), "data_o", "no"), Err(name_error("is not an input of it", "no")));
}

/// Enough operations for a simulator to cache the results.
fn mixer() -> Arc<Module> {
    let m = Builder::new("mixer");
    let (a, b) = (m.input("a_i", 16), m.input("b_i", 16));
    let mixed = (0..100).fold(a, |mixed, round| (mixed + b) ^ m.constant(16, round * 77));
    m.output("mixed_o", mixed);
    m.output("last_o", mixed.bits(7, 0));
    m.finish().unwrap()
}

fn mixed(a: u64, b: u64) -> u64 {
    (0..100).fold(a, |mixed, round| ((mixed + b) & 0xffff) ^ (round * 77))
}

/// Arguments that stay, change one at a time, return, and are zero at first, for two instances of one module.
#[test]
fn results_of_an_instance_follow_its_arguments() {
    let m = Builder::new("two");
    let [a, b, c] = ["a_i", "b_i", "c_i"].map(|name| m.input(name, 16));
    let first = m.instance("u_first", &mixer(), &[("a_i", a), ("b_i", b)]);
    let second = m.instance("u_second", &mixer(), &[("a_i", first[0]), ("b_i", c)]);
    m.output("mixed_o", second[0]);
    m.output("last_o", first[1]);
    let mut s = Simulator::new(&m.finish().unwrap()).unwrap();
    let words = [
        [0, 0, 0],
        [0, 0, 0],
        [7, 0, 0],
        [7, 9, 0],
        [7, 9, 0],
        [7, 9, 0xffff],
        [9, 7, 0xffff],
        [9, 7, 0],
        [0, 0, 0],
        [0, 1, 0],
    ];
    for _ in 0..2 {
        for [a, b, c] in words {
            s.set_all([a, b, c]);
            s.cycle();
            assert_eq!(s.outputs(), [mixed(mixed(a, b), c), mixed(a, b) & 0xff], "{a} {b} {c}");
        }
        s.restart();
    }
}
