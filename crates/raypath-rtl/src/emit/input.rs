//! The input's registers: the ports of all operations, selected by opcode.

use crate::allocate::plan::Plan;
use crate::config::Control;
use crate::emit::boundary::{StepBuilder, Wires};
use crate::emit::elastic::Registers;
use crate::emit::folded::Folded;
use crate::emit::interface;
use crate::emit::library::Library;
use crate::emit::positions::Positions;
use crate::error::Error;
use crate::ir::graph::{Kind, NodeId, Op, PortBit};
use crate::ir::units::Unit;
use raypath_hdl::text::Package;
use raypath_hdl::{Builder, Module, Wire};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A port of the datapath, without its direction suffix.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Port {
    pub name: String,
    pub width: u32,
    /// Whether any operation reads it.
    pub read: bool,
}

/// The input ports of all operations. Ports of the same name are one port.
pub fn ports(plan: &Plan) -> Vec<Port> {
    let mut ports: Vec<Port> = Vec::new();
    for (op, graph) in plan.operations.iter().enumerate() {
        for &id in &graph.inputs {
            let Op::Input(PortBit { port, bit }) = &graph.node(id).op else { continue };
            let width = match (graph.node(id).kind, bit) {
                (_, Some((_, width))) => *width,
                (Kind::Word(width), None) => width,
                (Kind::Number | Kind::Order | Kind::Cut(..), None) => plan.number_width(0),
            };
            let read = plan.steps[0].layout.slot(op, id).is_some();
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

/// The module `raypath_input`: the input ports that the job's operation reads, and shared registers.
pub fn input(plan: &Plan, library: &Library, package: &Arc<Package>) -> Result<Arc<Module>, Error> {
    let m = Builder::new("raypath_input");
    m.package(package);
    m.doc("The input's registers: each operation's ports, chosen by opcode, in registers that the operations share.");
    let opcode = m.input("opcode_i", plan.opcode_width());
    m.enumerate_input(interface::opcode_input());
    let wires: BTreeMap<String, Wire<'_>> = ports(plan)
        .into_iter()
        .filter(|port| port.read)
        .map(|port| (port.name.clone(), m.input(&format!("{}_i", port.name), port.width)))
        .collect();
    let mut wires = Ports { plan, wires };
    let positions = Positions::new(&m, plan);
    let at = StepBuilder { m: &m, plan, library, step: 0, opcode, positions: Some(&positions) };
    if let Some(rounds) = &plan.rounds {
        Folded::new(at, rounds, Some(m.input("valid_i", 1))).store(&mut wires)?;
        return Ok(m.finish()?);
    }
    let registers = Registers::new(at, at.next(&mut wires)?);
    match plan.microarchitecture.control {
        Control::Skid => registers.skid_buffers(None),
        Control::Credit => registers.plain(),
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
        let graph = &self.plan.operations[op];
        let Op::Input(PortBit { port, bit }) = &graph.node(id).op else { return Err(graph.unplaced(id)) };
        let wire = *self.wires.get(port).ok_or_else(|| graph.unplaced(id))?;
        Ok(match (graph.node(id).kind, bit) {
            (_, Some((bit, _))) => wire.bit(*bit),
            (Kind::Word(width), None) => wire.lower(width),
            (Kind::Number | Kind::Order | Kind::Cut(..), None) => wire,
        })
    }

    fn cut(&mut self, unit: Unit) -> Result<Vec<(String, Wire<'m>)>, Error> {
        Err(Error::PartApart { unit: unit.stem(), step: "input".to_string() })
    }
}
