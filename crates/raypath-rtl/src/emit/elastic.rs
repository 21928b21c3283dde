//! The registers of a boundary: skid buffers that stall, registers that never do, or the FIFO that such end in.

use crate::emit::control;
use crate::emit::library::Library;
use crate::error::Error;
use raypath_hdl::{Builder, Wire};

/// What a register takes.
pub struct Next<'m> {
    /// The register's name without `_q`.
    pub name: String,
    pub wire: Wire<'m>,
    /// Who lives there, in words.
    pub live_values: String,
}

/// Adds registers, their handshake and output ports. `hold` keeps the job in the registers before. Returns whether the
/// step hands on its job in this cycle.
pub fn skid_buffers<'m>(m: &'m Builder, library: &Library, next: Vec<Next<'m>>, hold: Option<Wire<'m>>) -> Wire<'m> {
    m.section("Registers: a skid buffer");
    let valid = m.input("valid_i", 1);
    let ready_after = m.input("ready_i", 1);
    let valid = hold.map_or(valid, |hold| valid & !hold);
    let control = m.instance("u_skid", &library.skid, &[("valid_i", valid), ("ready_i", ready_after)]);
    let (ready, valid_out, load_front, arrives) = (control[0], control[1], control[2], control[3]);
    m.output("ready_o", hold.map_or(ready, |hold| ready & !hold));
    m.output("valid_o", valid_out);
    for Next { name, wire, live_values } in next {
        let bits = wire.width();
        let wire = wire.named(&format!("{name}_d"));
        let spare = m.register(&format!("{name}_spare_q"), bits);
        let front = m.register(&format!("{name}_q"), bits);
        if !live_values.is_empty() {
            front.wire().comment(live_values);
        }
        spare.next_when(arrives, wire);
        front.next_when(load_front, arrives.mux(wire, spare.wire()));
        m.output(&format!("{name}_o"), front.wire());
    }
    valid & ready
}

/// Adds registers that take what comes in every cycle.
pub fn plain<'m>(m: &'m Builder, next: Vec<Next<'m>>) -> Wire<'m> {
    m.section("Registers, which never stall");
    let valid = m.input("valid_i", 1);
    let valid_out = m.register("valid_q", 1).reset_to(0);
    valid_out.next(valid);
    m.output("valid_o", valid_out.wire());
    for Next { name, wire, live_values } in next {
        let register = m.register(&format!("{name}_q"), wire.width());
        if !live_values.is_empty() {
            register.wire().comment(live_values);
        }
        register.next(wire.named(&format!("{name}_d")));
        m.output(&format!("{name}_o"), register.wire());
    }
    valid
}

/// Adds the exit FIFO: a register that the sink sees, and `depth` behind it.
pub fn exit<'m>(m: &'m Builder, next: Vec<Next<'m>>, depth: u32) -> Result<Wire<'m>, Error> {
    m.section("Registers: a FIFO with a place for every job that was let in");
    let valid = m.input("valid_i", 1);
    let ready_after = m.input("ready_i", 1);
    let control = m.instance("u_exit", &control::exit(depth)?, &[("valid_i", valid), ("ready_i", ready_after)]);
    let (valid_out, load_front, from_store, store, read) = (control[0], control[1], control[2], control[3], control[4]);
    m.output("valid_o", valid_out);
    for Next { name, wire, live_values } in next {
        let bits = wire.width();
        let wire = wire.named(&format!("{name}_d"));
        let mut oldest: Option<Wire<'m>> = None;
        for place in 0..depth {
            let stored = m.register(&format!("{name}_store_{place}_q"), bits);
            stored.next_when(store.bit(place), wire);
            let shown = stored.wire() & read.bit(place).replicate(bits);
            oldest = Some(oldest.map_or(shown, |others| others | shown));
        }
        let oldest = oldest.unwrap_or(wire).named(&format!("{name}_oldest"));
        let front = m.register(&format!("{name}_q"), bits);
        if !live_values.is_empty() {
            front.wire().comment(live_values);
        }
        front.next_when(load_front, from_store.mux(oldest, wire));
        m.output(&format!("{name}_o"), front.wire());
    }
    Ok(valid)
}
