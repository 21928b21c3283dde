//! The top module: input registers, stages, output, in a row.

use crate::boundary::OPCODE_WIDTH;
use crate::error::Error;
use crate::input;
use crate::library::Library;
use crate::output;
use crate::plan::Plan;
use crate::stage;
use raypath_hdl::{Builder, Module, Wire};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The top module, and those of its stages: the input's registers, then stage 1 and so on.
#[derive(Debug)]
pub struct Pipeline {
    pub top: Arc<Module>,
    pub stages: Vec<Arc<Module>>,
}

/// Builds the module `raypath` and all below it. `doc` is its head comment.
pub fn pipeline(plan: &Plan, library: &Library, doc: &[String]) -> Result<Pipeline, Error> {
    let m = Builder::new("raypath");
    for line in doc {
        m.doc(line);
    }
    let mut wires: BTreeMap<String, Wire<'_>> = BTreeMap::new();
    wires.insert("valid".to_string(), m.input("input_valid_i", 1));
    wires.insert("opcode".to_string(), m.input("opcode_i", OPCODE_WIDTH));
    let output_ready = m.input("output_ready_i", 1);
    let mut unread = Vec::new();
    for port in input::ports(plan, library) {
        let wire = m.input(&format!("{}_i", port.name), port.width);
        if port.read {
            wires.insert(port.name, wire);
        } else {
            unread.push(wire);
        }
    }
    if !unread.is_empty() {
        m.section("Ports that no configured rule reads");
        m.unused("unused_ports", &unread);
    }

    m.section("The pipeline");
    let mut modules = vec![("input".to_string(), input::input(plan, library)?)];
    for number in 1..plan.stages.len() {
        modules.push((format!("stage_{number}"), stage::stage(plan, library, number)?));
    }
    let mut ready_before: Option<raypath_hdl::Forward<'_>> = None;
    for (index, (name, module)) in modules.iter().enumerate() {
        let next = modules.get(index + 1);
        let ready_after = next.map(|(next, _)| m.forward(&format!("ready_of_{next}"), 1));
        wires.insert("ready".to_string(), ready_after.map_or(output_ready, |forward| forward.wire()));
        wires = instance(&m, name, module, &wires);
        let ready = wires.get("ready").copied();
        match (ready_before, ready) {
            (Some(forward), Some(ready)) => forward.drive(ready),
            (None, Some(ready)) => m.output("input_ready_o", ready),
            (_, None) => {}
        }
        ready_before = ready_after;
    }

    m.output("output_valid_o", wires["valid"]);
    m.output("opcode_o", wires["opcode"]);
    let output = output::output(plan, library)?;
    for (name, wire) in instance(&m, "output", &output, &wires) {
        m.output(&format!("{name}_o"), wire);
    }
    let stages = modules.into_iter().map(|(_, module)| module).collect();
    Ok(Pipeline { top: m.finish()?, stages })
}

/// An instance whose inputs are wires of the same names; gives its outputs by name.
fn instance<'m>(
    m: &'m Builder,
    name: &str,
    module: &Arc<Module>,
    wires: &BTreeMap<String, Wire<'m>>,
) -> BTreeMap<String, Wire<'m>> {
    let connections: Vec<(&str, Wire<'m>)> =
        module.inputs().iter().filter_map(|port| Some((port.name.as_str(), *wires.get(port.stem())?))).collect();
    let outputs = m.instance(&format!("u_{name}"), module, &connections);
    module.outputs().iter().map(|port| port.stem().to_string()).zip(outputs).collect()
}
