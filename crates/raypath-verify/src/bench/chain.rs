//! The parts of a unit put together again, without the registers that would stand between them.

use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// A module with the inputs of the first part and the outputs of the last. What leaves a part by the port `x_o` enters
/// the next by `x_i`; a port that is left over or missing is an error.
pub fn chain(parts: &[Arc<Module>]) -> Result<Arc<Module>, Error> {
    let name = parts.first().map_or("nothing", |part| part.name());
    let m = Builder::new(&format!("chain_of_{name}"));
    let inputs = parts.iter().take(1).flat_map(|first| first.inputs().iter().map(move |port| (first, &port.name)));
    let mut values: Vec<(String, Wire<'_>)> =
        inputs.map(|(first, name)| (name.clone(), m.input(name, first.port_width(name).unwrap_or_default()))).collect();
    for (place, part) in parts.iter().enumerate() {
        if let Some((name, _)) = values.iter().find(|(name, _)| part.inputs().iter().all(|port| port.name != *name)) {
            return Err(Error::Name {
                module: part.name().to_string(),
                name: name.clone(),
                problem: "is no input, while the part before gives it".to_string(),
            });
        }
        let connected: Vec<(&str, Wire<'_>)> = values.iter().map(|(name, wire)| (name.as_str(), *wire)).collect();
        let outputs = m.instance(&format!("u_part_{}", place + 1), part, &connected);
        let stems = part.outputs().iter().map(|port| port.name.strip_suffix("_o").unwrap_or(&port.name));
        values = stems.map(|stem| format!("{stem}_i")).zip(outputs).collect();
    }
    for (port, (_, wire)) in parts.iter().next_back().into_iter().flat_map(|last| last.outputs()).zip(values) {
        m.output(&port.name, wire);
    }
    m.finish()
}
