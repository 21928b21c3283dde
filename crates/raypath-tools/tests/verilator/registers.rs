//! Registers: enables, resets in any cycle, nested instances.

use crate::verilator::compare::agree;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use raypath_hdl::{Builder, Module};
use std::sync::Arc;

#[test]
fn registers_and_instances() {
    let m = Builder::new("nested");
    let (a, b) = (m.input("a_i", 33), m.input("b_i", 33));
    let (go, hold) = (m.input("go_i", 1), m.input("hold_i", 1));
    let cell = cell();
    let pair = pair(&cell);
    m.section("Pairs");
    let first = m.instance("u_first", &pair, &[("a_i", a), ("go_i", go)]);
    let second = m.instance("u_second", &pair, &[("a_i", first[0] ^ b), ("go_i", go & !hold)]);
    let late = m.instance("u_late", &cell, &[("a_i", second[0]), ("go_i", second[1])]);
    m.section("A ring that is read before it is driven");
    let ring = m.forward("ring", 33);
    let held = m.register("held_q", 33).reset_to(0x1_2345_6789);
    held.next_when(go, ring.wire() + late[0]);
    ring.drive(hold.mux(held.wire(), held.wire() - b));
    m.output("first_o", first[0]);
    m.output("late_o", late[0]);
    m.output("ring_o", ring.wire());
    agree(&m.finish().expect("a module"), &mut ChaCha8Rng::seed_from_u64(2), 20_000);
}

/// A module with a register of every kind.
fn cell() -> Arc<Module> {
    let m = Builder::new("cell_unit");
    m.doc("Four registers: with and without enable, with and without reset.");
    let (a, go) = (m.input("a_i", 33), m.input("go_i", 1));
    m.section("State");
    let plain = m.register("plain_q", 33);
    let enabled = m.register("enabled_q", 33);
    let reset = m.register("reset_q", 33).reset_to(1);
    let both = m.register("both_q", 33).reset_to(0x1_ffff_ffff);
    plain.next(a);
    enabled.next_when(go, plain.wire() + a);
    reset.next(reset.wire() + enabled.wire());
    both.next_when(go, both.wire() ^ reset.wire());
    m.output("sum_o", (both.wire() + plain.wire()) ^ enabled.wire());
    m.output("odd_o", both.wire().bit(0));
    m.finish().expect("a cell")
}

fn pair(cell: &Arc<Module>) -> Arc<Module> {
    let m = Builder::new("pair_unit");
    let (a, go) = (m.input("a_i", 33), m.input("go_i", 1));
    let left = m.instance("u_left", cell, &[("a_i", a), ("go_i", go)]);
    // The lowest bit of the right sum is unread, which must not be a lint.
    let right = m.instance("u_right", cell, &[("a_i", !left[0]), ("go_i", !left[1])]);
    m.output("sum_o", left[0] - right[0]);
    m.output("odd_o", left[1]);
    m.finish().expect("a pair")
}
