//! Registers, enables and the asynchronous reset.

use raypath_hdl::{Builder, Module, Simulator};
use std::sync::Arc;

/// Three registers that load `d_i`: always, if `en_i` is 1, and if `en_i` is 1 with a reset to 9.
fn three_registers() -> Arc<Module> {
    let m = Builder::new("three");
    let (d, en) = (m.input("d_i", 8), m.input("en_i", 1));
    let (plain, held, reset) =
        (m.register("plain_q", 8), m.register("held_q", 8), m.register("reset_q", 8).reset_to(9));
    plain.next(d);
    held.next_when(en, d);
    reset.next_when(en, d);
    for (name, register) in [("plain_o", plain), ("held_o", held), ("reset_o", reset)] {
        m.output(name, register.wire());
    }
    m.finish().unwrap()
}

struct Bench {
    simulator: Simulator,
}

impl Bench {
    fn new() -> Self {
        Self { simulator: Simulator::new(&three_registers()).unwrap() }
    }

    /// The outputs in a cycle with these inputs.
    fn cycle(&mut self, d: u64, en: u64) -> &[u64] {
        self.simulator.set_all([d, en]);
        self.simulator.cycle();
        self.simulator.outputs()
    }

    fn settled(&mut self) -> &[u64] {
        self.simulator.evaluate([])
    }
}

#[test]
fn registers_take_their_values_at_the_edge() {
    let mut bench = Bench::new();
    assert_eq!(bench.cycle(1, 1), [0, 0, 9]);
    assert_eq!(bench.cycle(2, 0), [1, 1, 1]);
    assert_eq!(bench.cycle(3, 0), [2, 1, 1]);
    assert_eq!(bench.cycle(4, 1), [3, 1, 1]);
    assert_eq!(bench.cycle(5, 0), [4, 4, 4]);
}

#[test]
fn settling_makes_no_edge() {
    let mut bench = Bench::new();
    bench.cycle(1, 1);
    bench.simulator.set_all([2]);
    assert_eq!(bench.settled(), [1, 1, 1]);
    assert_eq!(bench.settled(), [1, 1, 1]);
    assert_eq!(bench.cycle(3, 1), [1, 1, 1]);
    assert_eq!(bench.settled(), [3, 3, 3]);
}

#[test]
fn the_reset_acts_at_once_and_holds() {
    let mut bench = Bench::new();
    bench.cycle(1, 1);
    assert_eq!(bench.settled(), [1, 1, 1]);
    bench.simulator.set_reset(true);
    assert!(bench.simulator.is_reset());
    assert_eq!(bench.settled(), [1, 1, 9], "without an edge");
    assert_eq!(bench.cycle(2, 1), [1, 1, 9]);
    assert_eq!(bench.cycle(3, 1), [2, 2, 9], "an enabled edge does not count");
    bench.simulator.set_reset(false);
    assert_eq!(bench.cycle(4, 0), [3, 3, 9], "held until the next enabled edge");
    assert_eq!(bench.cycle(5, 1), [4, 3, 9]);
    assert_eq!(bench.settled(), [5, 5, 5]);
}

#[test]
fn a_reset_pulse_between_edges_counts() {
    let mut bench = Bench::new();
    bench.cycle(1, 1);
    bench.simulator.set_reset(true);
    bench.simulator.set_reset(false);
    assert_eq!(bench.settled(), [1, 1, 9]);
}

#[test]
fn simulators_of_one_module_are_independent_and_can_move_to_threads() {
    let module = three_registers();
    let results: Vec<u64> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4)
            .map(|n| {
                let mut simulator = Simulator::new(&module).unwrap();
                scope.spawn(move || {
                    simulator.set_all([n]);
                    simulator.cycle();
                    simulator.cycle();
                    simulator.outputs()[0]
                })
            })
            .collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert_eq!(results, [0, 1, 2, 3]);
}

/// Unlike a reset, a restart also clears registers without a reset value.
#[test]
fn a_restarted_simulator_equals_a_new_one() {
    let module = three_registers();
    let mut simulator = Simulator::new(&module).unwrap();
    simulator.set_all([5, 1]);
    simulator.cycle();
    simulator.set_reset(true);
    simulator.restart();
    assert!(!simulator.is_reset());
    for _ in 0..2 {
        simulator.cycle();
    }
    // The inputs are 0 again, and the register without an enable has loaded 0.
    assert_eq!(simulator.outputs(), [0, 0, 9]);
}
