//! Joins the parts of a split unit, without the registers between them.

use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// A module with the inputs of the first part and the outputs of the last. The output `x_o` of a part drives the input
/// `x_i` of the next part.
///
/// # Errors
/// An output without such an input, or an input without such an output.
pub fn chain(parts: &[Arc<Module>]) -> Result<Arc<Module>, Error> {
    let name = parts.first().map_or("no_part", |part| part.name());
    let m = Builder::new(&format!("chain_of_{name}"));
    let inputs = parts.iter().take(1).flat_map(|first| first.inputs().iter().map(move |port| (first, &port.name)));
    let mut values: Vec<(String, Wire<'_>)> =
        inputs.map(|(first, name)| (name.clone(), m.input(name, first.port_width(name).unwrap_or_default()))).collect();
    for (index, part) in parts.iter().enumerate() {
        if let Some((name, _)) = values.iter().find(|(name, _)| part.inputs().iter().all(|port| port.name != *name)) {
            return Err(Error::Name {
                module: part.name().to_string(),
                name: name.clone(),
                problem: "is no input of this part, but an output of the part before".to_string(),
            });
        }
        let connected: Vec<(&str, Wire<'_>)> = values.iter().map(|(name, wire)| (name.as_str(), *wire)).collect();
        let outputs = m.instance(&format!("u_part_{}", index + 1), part, &connected);
        let stems = part.outputs().iter().map(|port| port.name.strip_suffix("_o").unwrap_or(&port.name));
        values = stems.map(|stem| format!("{stem}_i")).zip(outputs).collect();
    }
    for (port, (_, wire)) in parts.iter().next_back().into_iter().flat_map(|last| last.outputs()).zip(values) {
        m.output(&port.name, wire);
    }
    m.finish()
}
