//! The outputs: from the last registers to the ports. The outputs of an operation are zero for jobs of other
//! operations.

use crate::allocate::plan::Plan;
use crate::emit::boundary::label;
use crate::emit::interface;
use crate::emit::library::Library;
use crate::emit::values::StepInputs;
use crate::error::Error;
use crate::ir::graph::NodeId;
use raypath_hdl::text::Package;
use raypath_hdl::{Builder, Label, Module, Wire};
use std::sync::Arc;

/// An output port without its direction suffix, and for each operation that has it the values of its bits, lowest
/// first.
struct OutputPort {
    name: String,
    arms: Vec<(usize, Vec<NodeId>)>,
}

/// The module `raypath_output`, without registers.
pub fn output(plan: &Plan, library: &Library, package: &Arc<Package>) -> Result<Arc<Module>, Error> {
    let m = Builder::new("raypath_output");
    m.package(package);
    m.doc("From the last registers to the ports. Outputs of other operations than the job's are zero.");
    let layout = &plan.steps[plan.last()].layout;
    let opcode = m.input("opcode_i", plan.opcode_width());
    let before = StepInputs::ports(&m, plan, library, plan.steps.len());
    m.group_inputs(interface::input(plan, library, plan.last()));

    let read = |op: usize, id: NodeId| {
        let slot = layout.slot(op, id);
        slot.and_then(|slot| before.read(slot)).ok_or_else(|| plan.operations[op].unplaced(id))
    };
    for port in ports(plan) {
        let mut arms: Vec<(Label, Wire<'_>)> = Vec::new();
        for (op, bits) in port.arms {
            let mut parts = bits.into_iter().map(|id| read(op, id)).collect::<Result<Vec<_>, Error>>()?;
            parts.reverse();
            arms.push((label(&plan.operations[op]), m.concat(&parts)));
        }
        let Some(width) = arms.first().map(|(_, wire)| wire.width()) else { continue };
        let shown = m.case(opcode, &arms, m.constant(width, 0));
        m.output(&format!("{}_o", port.name), shown.named(&port.name));
    }
    Ok(m.finish()?)
}

fn ports(plan: &Plan) -> Vec<OutputPort> {
    let mut ports: Vec<OutputPort> = Vec::new();
    for (op, graph) in plan.operations.iter().enumerate() {
        for value in &graph.outputs {
            let known = ports.iter().position(|port| port.name == value.port.port).unwrap_or_else(|| {
                ports.push(OutputPort { name: value.port.port.clone(), arms: Vec::new() });
                ports.len() - 1
            });
            let arms = &mut ports[known].arms;
            match arms.last_mut() {
                Some((last, bits)) if *last == op => bits.push(value.node),
                _ => arms.push((op, vec![value.node])),
            }
        }
    }
    ports
}
