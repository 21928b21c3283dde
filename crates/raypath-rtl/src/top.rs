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

/// The module `raypath`. `doc` is its head comment.
pub fn top(plan: &Plan, library: &Library, doc: &[String]) -> Result<Arc<Module>, Error> {
    let m = Builder::new("raypath");
    for line in doc {
        m.doc(line);
    }
    let mut wires: BTreeMap<String, Wire<'_>> = BTreeMap::new();
    for (name, width) in [("valid", 1), ("opcode", OPCODE_WIDTH)] {
        let port = if name == "valid" { "input_valid_i".to_string() } else { format!("{name}_i") };
        wires.insert(name.to_string(), m.input(&port, width));
    }
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
    Ok(m.finish()?)
}

/// An instance whose inputs are wires of the same names; gives its outputs by name.
fn instance<'m>(
    m: &'m Builder,
    name: &str,
    module: &Arc<Module>,
    wires: &BTreeMap<String, Wire<'m>>,
) -> BTreeMap<String, Wire<'m>> {
    let stem = |port: &str| port[..port.len().saturating_sub(2)].to_string();
    let connections: Vec<(&str, Wire<'m>)> =
        module.inputs().iter().filter_map(|port| Some((port.name.as_str(), *wires.get(&stem(&port.name))?))).collect();
    let outputs = m.instance(&format!("u_{name}"), module, &connections);
    module.outputs().iter().map(|port| stem(&port.name)).zip(outputs).collect()
}
