//! Simulation in lanes: lanes are independent, and values are in their lanes.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_hdl::{Builder, LANES, LaneSimulator, Module, Simulator};
use std::sync::Arc;

/// Registers with and without reset and enable, a swap of two and one within one, a sum, and a register of a constant.
fn registers() -> Arc<Module> {
    let m = Builder::new("registers");
    let (d, en) = (m.input("d_i", 33), m.input("en_i", 1));
    let plain = m.register("plain_q", 33);
    let held = m.register("held_q", 33);
    let reset = m.register("reset_q", 33).reset_to(9);
    let (a, b) = (m.register("a_q", 33).reset_to(0x1_5555_5555), m.register("b_q", 33));
    let constant = m.register("constant_q", 33);
    plain.next(d);
    held.next_when(en, d);
    reset.next_when(en, plain.wire() + d);
    a.next(b.wire());
    b.next_when(en, a.wire());
    constant.next(m.constant(33, 5));
    // Its halves are exchanged, and its lowest bit is part of its own enable.
    let halves = m.register("halves_q", 34).reset_to(0x2_1234_5679);
    let turned = m.concat(&[halves.wire().bits(16, 0), halves.wire().bits(33, 17)]);
    halves.next_when(halves.wire().bit(0) | en, turned);
    m.output("halves_o", halves.wire());
    for (name, register) in
        [("plain_o", plain), ("held_o", held), ("reset_o", reset), ("a_o", a), ("b_o", b), ("constant_o", constant)]
    {
        m.output(name, register.wire());
    }
    m.output("through_o", d);
    m.output("seven_o", m.constant(3, 7));
    m.finish().unwrap()
}

fn random_lanes(random: &mut ChaCha8Rng) -> [u64; LANES] {
    std::array::from_fn(|_| random.random())
}

/// An action on both simulators.
#[derive(Clone)]
enum Action {
    Set(Box<[[u64; LANES]; 2]>),
    SetAll(u64),
    Cycle,
    Settle,
    Reset(bool),
    Restart,
}

fn random_action(random: &mut ChaCha8Rng) -> Action {
    match random.random_range(0..20) {
        0..8 => Action::Set(Box::new([random_lanes(random), random_lanes(random)])),
        8 => Action::SetAll(random.random()),
        9..16 => Action::Cycle,
        16 => Action::Settle,
        17 => Action::Reset(true),
        18 => Action::Reset(false),
        _ => Action::Restart,
    }
}

#[test]
fn every_lane_equals_a_simulator_after_all_actions() {
    let module = registers();
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let actions: Vec<Action> = (0..300).map(|_| random_action(&mut random)).collect();
    let mut lanes = LaneSimulator::new(&module).unwrap();
    let mut single: Vec<Simulator> = (0..LANES).step_by(31).map(|_| Simulator::new(&module).unwrap()).collect();
    let (d, en) = (lanes.input("d_i").unwrap(), lanes.input("en_i").unwrap());
    let outputs: Vec<_> = module.outputs().iter().map(|port| lanes.output(&port.name).unwrap()).collect();
    for (step, action) in actions.iter().enumerate() {
        match action {
            Action::Set(values) => {
                lanes.set(d, &values[0]);
                lanes.set(en, &values[1]);
            }
            Action::SetAll(value) => lanes.set(d, &[*value; LANES]),
            Action::Cycle => lanes.cycle(),
            Action::Settle => lanes.settle(),
            Action::Reset(asserted) => lanes.set_reset(*asserted),
            Action::Restart => lanes.restart(),
        }
        for (place, single) in single.iter_mut().enumerate() {
            match action {
                Action::Set(values) => {
                    single.set(d, values[0][place * 31]);
                    single.set(en, values[1][place * 31]);
                }
                Action::SetAll(value) => single.set(d, *value),
                Action::Cycle => single.cycle(),
                Action::Settle => single.settle(),
                Action::Reset(asserted) => single.set_reset(*asserted),
                Action::Restart => single.restart(),
            }
            assert_eq!(single.is_reset(), lanes.is_reset());
        }
        for (port, &output) in module.outputs().iter().zip(&outputs) {
            let shown = lanes.get(output);
            for (place, single) in single.iter().enumerate() {
                assert_eq!(shown[place * 31], single.get(output), "{} after step {step}", port.name);
            }
        }
    }
}

#[test]
fn values_find_their_lanes_at_every_width() {
    let m = Builder::new("through");
    for width in 1..=64 {
        m.output(&format!("o{width}_o"), m.input(&format!("i{width}_i"), width));
    }
    let mut simulator = LaneSimulator::new(&m.finish().unwrap()).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(3);
    for width in 1..=64 {
        let input = simulator.input(&format!("i{width}_i")).unwrap();
        let output = simulator.output(&format!("o{width}_o")).unwrap();
        let values = random_lanes(&mut random);
        simulator.set(input, &values);
        simulator.settle();
        let mask = u64::MAX >> (64 - width);
        assert_eq!(simulator.get(output), values.map(|value| value & mask), "width {width}");
        simulator.set(input, &[values[5]; LANES]);
        assert_eq!(simulator.get(output), values.map(|value| value & mask), "not before it settles");
        simulator.settle();
        assert_eq!(simulator.get(output), [values[5] & mask; LANES], "width {width}");
    }
}

#[test]
fn ports_and_errors_equal_those_of_a_simulator() {
    let module = registers();
    let (lanes, single) = (LaneSimulator::new(&module).unwrap(), Simulator::new(&module).unwrap());
    assert_eq!(lanes.input("d_i").unwrap(), single.input("d_i").unwrap());
    assert_eq!(lanes.output("a_o").unwrap(), single.output("a_o").unwrap());
    assert_eq!(lanes.input("a_o").unwrap_err().to_string(), single.input("a_o").unwrap_err().to_string());
    assert_eq!(lanes.output("none").unwrap_err().to_string(), single.output("none").unwrap_err().to_string());
}
