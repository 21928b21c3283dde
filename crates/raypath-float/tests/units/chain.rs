//! The parts of a unit put together again, without the registers that would stand between them.

use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// A module with the inputs of the first part and the outputs of the last. What leaves a part by the port `x_o` enters
/// the next by `x_i`; the parts must have been made for each other, with no port left over.
pub fn chain(parts: &[Arc<Module>]) -> Result<Arc<Module>, Error> {
    let m = Builder::new(&format!("chain_of_{}", parts[0].name()));
    let width = |part: &Module, name: &str| part.port_width(name).expect("a port of its own");
    let inputs = parts[0].inputs().iter().map(|port| (port.name.as_str(), width(&parts[0], &port.name)));
    let mut values: Vec<(String, Wire<'_>)> =
        inputs.map(|(name, width)| (name.to_string(), m.input(name, width))).collect();
    for (place, part) in parts.iter().enumerate() {
        assert_eq!(values.len(), part.inputs().len(), "{}", part.name());
        let connected: Vec<(&str, Wire<'_>)> = values.iter().map(|(name, wire)| (name.as_str(), *wire)).collect();
        let outputs = m.instance(&format!("u_part_{}", place + 1), part, &connected);
        let names = part.outputs().iter().map(|port| port.name.as_str());
        let stems = names.map(|name| name.strip_suffix("_o").expect("an output's suffix"));
        values = stems.map(|stem| format!("{stem}_i")).zip(outputs).collect();
    }
    for (port, (_, wire)) in parts.iter().flat_map(|part| part.outputs()).rev().zip(values.iter().rev()) {
        m.output(&port.name, *wire);
    }
    m.finish()
}
