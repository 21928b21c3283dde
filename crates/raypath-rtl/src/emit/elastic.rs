//! The registers after a step: a skid buffer, a register that never stalls, or the FIFO at the exit.

use crate::emit::boundary::{Next, StepBuilder};
use crate::emit::control::{Exit, Plain, Skid};
use crate::emit::interface;
use crate::emit::library::Library;
use crate::error::Error;
use raypath_hdl::text::PortGroup;
use raypath_hdl::{Builder, Module, Register, Wire};
use std::sync::Arc;

/// The registers after a step.
pub struct Registers<'m, 'p> {
    m: &'m Builder,
    library: &'p Library,
    /// The output port that shows them.
    output: PortGroup,
    next: Vec<Next<'m>>,
}

impl<'m, 'p> Registers<'m, 'p> {
    /// The registers after a step of a plan, which take `next`.
    pub fn new(at: StepBuilder<'m, 'p>, mut next: Vec<Next<'m>>) -> Self {
        let StepBuilder { m, plan, library, step, .. } = at;
        let output = interface::output(plan, library, step);
        next.iter_mut().for_each(|next| next.wire = next.wire.named(&format!("{}_d", next.name)));
        Self { m, library, output, next }
    }

    /// Adds skid buffers, their handshake and output ports. `hold` keeps the job in the registers before. Returns
    /// whether the job leaves the step in this cycle.
    pub fn skid_buffers(self, hold: Option<Wire<'m>>) -> Wire<'m> {
        let (m, library) = (self.m, self.library);
        m.section("Registers: a skid buffer");
        let valid = m.input("valid_i", 1);
        let ready_after = m.input("ready_i", 1);
        let valid = hold.map_or(valid, |hold| valid & !hold);
        let skid = Skid::instance(m, &library.skid, &[("valid_i", valid), ("ready_i", ready_after)]);
        m.output("ready_o", hold.map_or(skid.ready, |hold| skid.ready & !hold));
        m.output("valid_o", skid.valid);
        let ports = [("valid_i", valid), ("ready_i", ready_after), ("ready_o", skid.ready), ("valid_o", skid.valid)];
        self.store("u_skid", &library.skid_buffer, &ports, |name, wire| skid.store(m, name, wire).to_vec());
        valid & skid.ready
    }

    /// Adds registers that take a job in every cycle.
    pub fn plain(self) -> Wire<'m> {
        let (m, library) = (self.m, self.library);
        m.section("Registers, which never stall");
        let valid = m.input("valid_i", 1);
        let register = Plain::new(m, valid);
        m.output("valid_o", register.valid.wire());
        let ports = [("valid_i", valid), ("valid_o", register.valid.wire())];
        let mut own = Some(register.valid);
        self.store("u_register", &library.register, &ports, |name, wire| {
            own.take().into_iter().chain([register.store(m, name, wire)]).collect()
        });
        valid
    }

    /// Adds the FIFO at the exit: a register that the sink sees, and `depth` jobs behind it.
    pub fn exit(self, depth: u32) -> Result<Wire<'m>, Error> {
        let m = self.m;
        m.section("Registers: a FIFO with a place for every job that holds a credit");
        let valid = m.input("valid_i", 1);
        let ready_after = m.input("ready_i", 1);
        let inputs = [("valid_i", valid), ("ready_i", ready_after)];
        let exit = Exit::instance(m, &Exit::module(depth)?, &inputs);
        m.output("valid_o", exit.valid);
        let ports = [inputs[0], inputs[1], ("valid_o", exit.valid)];
        self.store("u_exit", &Exit::buffer(depth)?, &ports, |name, wire| exit.store(m, name, wire));
        Ok(valid)
    }

    /// Adds the data registers that `registers` gives for each word, the one that is shown last, and their ports.
    fn store(
        self,
        instance: &str,
        buffer: &Arc<Module>,
        ports: &[(&str, Wire<'m>)],
        mut registers: impl FnMut(&str, Wire<'m>) -> Vec<Register<'m>>,
    ) {
        let mut all = Vec::new();
        for Next { name, wire } in &self.next {
            let own = registers(name, *wire);
            self.m.output(&format!("{name}_o"), own[own.len() - 1].wire());
            all.extend(own);
        }
        let of = |port: &str| self.next.iter().find(|next| port == format!("{}_o", next.name));
        let next: Vec<Wire<'m>> = self.output.members.iter().filter_map(|(port, _)| of(port)).map(|n| n.wire).collect();
        self.m.bank(instance, buffer, ports, &next, &all, self.output);
    }
}
