//! A skid buffer.

use super::buffer::buffer;
use raypath_hdl::{Builder, Module, Register, Wire};
use std::sync::Arc;

/// Valid, ready and the enables of the data registers of a skid buffer.
///
/// The buffer has two registers: `data`, which the next stage sees, and `spare`, which takes every arriving job and so
/// holds it if `data` cannot leave. Its ready comes from a flip-flop, so there is no combinational path from the sink
/// to the source.
///
/// `data` loads the arriving job, or else what `spare` holds: the same choice that `spare` makes for itself. A bit
/// therefore costs two multiplexers instead of three.
#[derive(Clone, Copy)]
pub struct Skid<'m> {
    pub ready: Wire<'m>,
    pub valid: Wire<'m>,
    pub load_front: Wire<'m>,
    pub arrives: Wire<'m>,
}

impl<'m> Skid<'m> {
    /// The control's registers.
    pub fn new(m: &'m Builder, valid: Wire<'m>, ready_after: Wire<'m>) -> Self {
        let front_full = m.register("front_full_q", 1).reset_to(0);
        let spare_empty = m.register("spare_empty_q", 1).reset_to(1);
        let arrives = (valid & spare_empty.wire()).named("arrives");
        let leaves = (!front_full.wire() | ready_after).named("leaves").comment("data_q is free after this edge");
        let refill = (arrives | !spare_empty.wire()).named("refill");
        front_full.next(!leaves | refill);
        spare_empty.next(spare_empty.wire().mux(leaves | !arrives, leaves));
        let load_front = (leaves & refill).named("load_front");
        Self { ready: spare_empty.wire(), valid: front_full.wire(), load_front, arrives }
    }

    /// The control in an instance `u_skid` of [`module`](Self::module).
    pub fn instance(m: &'m Builder, module: &Arc<Module>, inputs: &[(&str, Wire<'m>)]) -> Self {
        let outputs = m.instance("u_skid", module, inputs);
        Self { ready: outputs[0], valid: outputs[1], load_front: outputs[2], arrives: outputs[3] }
    }

    /// The output ports of [`module`](Self::module), in their order.
    fn outputs(self) -> [(&'static str, Wire<'m>); 4] {
        let Self { ready, valid, load_front, arrives } = self;
        [("ready_o", ready), ("valid_o", valid), ("load_front_o", load_front), ("arrives_o", arrives)]
    }

    /// The control as a module, `raypath_skid`.
    pub fn module() -> Result<Arc<Module>, raypath_hdl::Error> {
        let m = Builder::new("raypath_skid");
        m.doc("Control of a skid buffer.");
        let skid = Skid::new(&m, m.input("valid_i", 1), m.input("ready_i", 1));
        skid.outputs().into_iter().for_each(|(name, wire)| m.output(name, wire));
        m.finish()
    }

    /// Control and data registers as a module, `raypath_skid`, with the width as a parameter.
    pub fn buffer() -> Result<Arc<Module>, raypath_hdl::Error> {
        let doc = [
            "A skid buffer: two registers of Width bits, one job per cycle. It cuts the combinational paths of",
            "valid, ready and data. data_q is what the next stage sees; data_spare_q takes every arriving job",
            "and holds it if data_q cannot leave.",
        ];
        buffer("raypath_skid", &doc, |m, data| {
            let skid = Skid::new(m, m.input("valid_i", 1), m.input("ready_i", 1));
            m.output("ready_o", skid.ready);
            m.output("valid_o", skid.valid);
            skid.store(m, "data", data)[1].wire()
        })
    }

    /// The data registers of a word: spare, then front.
    pub fn store(self, m: &'m Builder, name: &str, word: Wire<'m>) -> [Register<'m>; 2] {
        let spare = m.register(&format!("{name}_spare_q"), word.width());
        let front = m.register(&format!("{name}_q"), word.width());
        spare.next_when(self.arrives, word);
        front.next_when(self.load_front, self.arrives.mux(word, spare.wire()));
        [spare, front]
    }
}
