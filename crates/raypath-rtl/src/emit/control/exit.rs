//! The FIFO at the exit of a pipeline that cannot stall.

use super::buffer::buffer;
use raypath_hdl::{Builder, Module, Register, Wire};
use std::sync::Arc;

/// Which of its registers the FIFO at the exit loads.
///
/// An arriving job goes straight to `data`, which the sink sees, if nothing waits, so the FIFO adds no cycle. One-hot
/// pointers select the stored jobs; they are the write enables and the read selects without a decoder.
#[derive(Clone, Copy)]
pub struct Exit<'m> {
    pub valid: Wire<'m>,
    pub load_front: Wire<'m>,
    pub from_store: Wire<'m>,
    pub store: Wire<'m>,
    pub read: Wire<'m>,
}

impl<'m> Exit<'m> {
    /// The control's registers. `depth` is the number of jobs stored behind the one that the sink sees, 1 to 63.
    pub fn new(m: &'m Builder, valid: Wire<'m>, ready_after: Wire<'m>, depth: u32) -> Self {
        let front_full = m.register("front_full_q", 1).reset_to(0);
        let waiting = m.register("waiting_q", u32::BITS - depth.leading_zeros()).reset_to(0);
        let write = m.register("write_q", depth).reset_to(1);
        let read = m.register("read_q", depth).reset_to(1);

        let leaves = (!front_full.wire() | ready_after).named("leaves").comment("data_q is free after this edge");
        let stored = waiting.wire().any().named("stored");
        let fetches = (leaves & stored).named("fetches");
        let stores = (valid & (stored | !leaves)).named("stores");
        let load_front = (leaves & (stored | valid)).named("load_front");
        front_full.next(!leaves | load_front);
        let width = waiting.wire().width();
        waiting.next(waiting.wire() + stores.extend(width) - fetches.extend(width));
        if depth > 1 {
            for (pointer, turns) in [(write, stores), (read, fetches)] {
                let wire = pointer.wire();
                pointer.next_when(turns, m.concat(&[wire.lower(depth - 1), wire.top()]));
            }
        } else {
            write.next(write.wire());
            read.next(read.wire());
        }
        let store = write.wire() & stores.replicate(depth);
        Self { valid: front_full.wire(), load_front, from_store: stored, store, read: read.wire() }
    }

    /// The control in an instance `u_exit` of [`module`](Self::module).
    pub fn instance(m: &'m Builder, module: &Arc<Module>, inputs: &[(&str, Wire<'m>)]) -> Self {
        let outputs = m.instance("u_exit", module, inputs);
        let [valid, load_front, from_store, store, read] = [0, 1, 2, 3, 4].map(|output| outputs[output]);
        Self { valid, load_front, from_store, store, read }
    }

    /// The output ports of [`module`](Self::module), in their order.
    fn outputs(self) -> [(&'static str, Wire<'m>); 5] {
        let Self { valid, load_front, from_store, store, read } = self;
        let [load, stored] = [("load_front_o", load_front), ("from_store_o", from_store)];
        [("valid_o", valid), load, stored, ("store_o", store), ("read_o", read)]
    }

    /// The control as a module, `raypath_exit`.
    pub fn module(depth: u32) -> Result<Arc<Module>, raypath_hdl::Error> {
        let m = Builder::new("raypath_exit");
        m.doc("Control of the FIFO at the exit.");
        let exit = Exit::new(&m, m.input("valid_i", 1), m.input("ready_i", 1), depth);
        exit.outputs().into_iter().for_each(|(name, wire)| m.output(name, wire));
        m.finish()
    }

    /// Control and data registers as a module, `raypath_exit`, with the width as a parameter.
    pub fn buffer(depth: u32) -> Result<Arc<Module>, raypath_hdl::Error> {
        let doc = [
            &format!(
                "The exit: data_q, which the sink sees, and a FIFO of {depth} jobs behind it, each of Width bits."
            ),
            "Credits ensure that no job arrives while all are full.",
        ];
        buffer("raypath_exit", &doc, |m, data| {
            let exit = Exit::new(m, m.input("valid_i", 1), m.input("ready_i", 1), depth);
            let store = exit.store.named("store");
            m.output("valid_o", exit.valid);
            let registers = Exit { store, ..exit }.store(m, "data", data);
            registers[registers.len() - 1].wire()
        })
    }

    /// The data registers of a word: the stored ones, then the one that the sink sees.
    pub fn store(self, m: &'m Builder, name: &str, word: Wire<'m>) -> Vec<Register<'m>> {
        self.store_with(m, name, word, |place, register, next| {
            register.next_when(place.map_or(self.load_front, |place| self.store.bit(place)), next);
        })
    }

    /// The same; `load` gives each register its enable and its next value. It is called with the place of a stored one.
    pub fn store_with(
        self,
        m: &'m Builder,
        name: &str,
        word: Wire<'m>,
        load: impl Fn(Option<u32>, Register<'m>, Wire<'m>),
    ) -> Vec<Register<'m>> {
        let bits = word.width();
        let mut registers = Vec::new();
        let mut oldest: Option<Wire<'m>> = None;
        for place in 0..self.store.width() {
            let stored = m.register(&format!("{name}_store_{place}_q"), bits);
            load(Some(place), stored, word);
            registers.push(stored);
            let shown = stored.wire() & self.read.bit(place).replicate(bits);
            oldest = Some(oldest.map_or(shown, |others| others | shown));
        }
        let oldest = oldest.unwrap_or(word).named(&format!("{name}_oldest"));
        let front = m.register(&format!("{name}_q"), bits);
        load(None, front, self.from_store.mux(oldest, word));
        registers.push(front);
        registers
    }
}
