use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// The parts of a unit put together again, without the registers that would stand between them: a module with the
/// inputs of the first part and the outputs of the last. What leaves a part by the port `x_o` enters the next by `x_i`.
///
/// # Errors
/// Parts that were not made for each other.
pub fn chain(parts: &[Arc<Module>]) -> Result<Arc<Module>, Error> {
    let name = parts.first().map_or("nothing", |part| part.name());
    let m = Builder::new(&format!("chain_of_{name}"));
    let mut values: Vec<(String, Wire<'_>)> = Vec::new();
    for port in parts.iter().take(1).flat_map(|part| part.inputs().iter().map(move |port| (part, port))) {
        let (part, port) = port;
        values.push((port.name.clone(), m.input(&port.name, part.signal(port.signal).width)));
    }
    for (place, part) in parts.iter().enumerate() {
        let connected: Vec<(&str, Wire<'_>)> = values.iter().map(|(name, wire)| (name.as_str(), *wire)).collect();
        let outputs = m.instance(&format!("u_part_{}", place + 1), part, &connected);
        values = part.outputs().iter().map(|port| format!("{}_i", port.stem())).zip(outputs).collect();
    }
    for (port, (_, wire)) in parts.iter().next_back().iter().flat_map(|part| part.outputs()).zip(&values) {
        m.output(&port.name, *wire);
    }
    m.finish()
}
