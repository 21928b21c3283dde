//! The input's registers: ports of all operations, one job's worth of registers.

use crate::boundary::{self, Wires};
use crate::config::Control;
use crate::elastic;
use crate::error::Error;
use crate::graph::{Kind, NodeId, Op, PortBit};
use crate::library::Library;
use crate::plan::Plan;
use crate::units::Unit;
use raypath_hdl::{Builder, Module, Wire};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A port of the datapath, direction suffix excluded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Port {
    pub name: String,
    pub width: u32,
    /// Whether any operation reads it.
    pub read: bool,
}

/// The input ports of all operations; those that operations name alike are one.
pub fn ports(plan: &Plan) -> Vec<Port> {
    let mut ports: Vec<Port> = Vec::new();
    for (op, traced) in plan.operations.iter().enumerate() {
        for &id in &traced.inputs {
            let Op::Input(PortBit { port, bit }) = &traced.node(id).op else { continue };
            let width = match (traced.node(id).kind, bit) {
                (_, Some((_, width))) => *width,
                (Kind::Word(width), None) => width,
                (Kind::Number | Kind::Order | Kind::Cut(..), None) => plan.number_width(0),
            };
            let read = plan.steps[0].layout.places[op].contains_key(&id);
            match ports.iter_mut().find(|known| known.name == *port) {
                Some(known) => {
                    known.width = known.width.max(width);
                    known.read |= read;
                }
                None => ports.push(Port { name: port.clone(), width, read }),
            }
        }
    }
    ports
}

/// The module `raypath_input`: what the job's operation reads of the ports, into registers that the operations share.
pub fn input(plan: &Plan, library: &Library) -> Result<Arc<Module>, Error> {
    let m = Builder::new("raypath_input");
    m.doc("The input's registers: each operation's ports, chosen by opcode, in registers that the operations share.");
    let opcode = m.input("opcode_i", plan.opcode_width());
    let wires: BTreeMap<String, Wire<'_>> = ports(plan)
        .into_iter()
        .filter(|port| port.read)
        .map(|port| (port.name.clone(), m.input(&format!("{}_i", port.name), port.width)))
        .collect();
    let mut wires = Ports { plan, wires };
    let next = boundary::next(&m, plan, library, 0, opcode, &mut wires)?;
    match plan.microarchitecture.control {
        Control::Skid => elastic::skid_buffers(&m, library, next, None),
        Control::Credit => elastic::plain(&m, next),
    };
    Ok(m.finish()?)
}

/// Input ports by name.
struct Ports<'m, 'p> {
    plan: &'p Plan,
    wires: BTreeMap<String, Wire<'m>>,
}

impl<'m> Wires<'m> for Ports<'m, '_> {
    fn named(&mut self, op: usize, id: NodeId) -> Result<Wire<'m>, Error> {
        let traced = &self.plan.operations[op];
        let Op::Input(PortBit { port, bit }) = &traced.node(id).op else { return Err(traced.unplaced(id)) };
        let wire = *self.wires.get(port).ok_or_else(|| traced.unplaced(id))?;
        Ok(match (traced.node(id).kind, bit) {
            (_, Some((bit, _))) => wire.bit(*bit),
            (Kind::Word(width), None) => wire.lower(width),
            (Kind::Number | Kind::Order | Kind::Cut(..), None) => wire,
        })
    }

    fn shared(&mut self, op: usize, id: NodeId) -> Result<Wire<'m>, Error> {
        self.named(op, id)
    }

    fn register(&mut self, op: usize, id: NodeId) -> Result<Wire<'m>, Error> {
        self.named(op, id)
    }

    fn cut(&mut self, unit: Unit) -> Result<Vec<(String, Wire<'m>)>, Error> {
        Err(Error::PartApart { unit: unit.stem(), step: "input".to_string() })
    }
}
