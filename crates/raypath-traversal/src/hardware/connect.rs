//! Instances and memories whose ports and columns have names.

use super::parameters::UnitParameters;
use raypath_hdl::{Builder, Module, Wire};
use std::sync::Arc;

/// Named wires.
pub type Named<'m> = Vec<(String, Wire<'m>)>;

/// The inputs of an instance.
#[derive(Default)]
pub struct Inputs<'m>(Named<'m>);

/// The outputs of an instance.
pub struct Outputs<'m> {
    builder: &'m Builder,
    ports: Named<'m>,
}

impl<'m> Inputs<'m> {
    /// Connects the port `<name>_i`.
    pub fn port(mut self, name: &str, wire: Wire<'m>) -> Self {
        self.0.push((format!("{name}_i"), wire));
        self
    }

    /// Connects a port `<name>_i` for each wire.
    pub fn ports(self, named: impl IntoIterator<Item = (String, Wire<'m>)>) -> Self {
        named.into_iter().fold(self, |inputs, (name, wire)| inputs.port(&name, wire))
    }

    /// Places the instance.
    pub fn place(self, builder: &'m Builder, instance: &str, module: &Arc<Module>) -> Outputs<'m> {
        let given: Vec<(&str, Wire<'m>)> = self.0.iter().map(|(name, wire)| (name.as_str(), *wire)).collect();
        let wires = builder.instance(instance, module, &given);
        let names = module.outputs().iter().map(|port| port.name.trim_end_matches("_o").to_string());
        Outputs { builder, ports: names.zip(wires).collect() }
    }
}

impl<'m> Outputs<'m> {
    /// The output `<name>_o`. If the module does not have it, the builder reports a wire that is not driven.
    pub fn port(&self, name: &str) -> Wire<'m> {
        let found = self.ports.iter().find(|(known, _)| known == name);
        found.map_or_else(|| self.builder.forward(&format!("missing_{name}"), 1).wire(), |(_, wire)| *wire)
    }

    /// The outputs whose names begin with `<stem>_`, in order, without the stem.
    pub fn under(&self, stem: &str) -> Named<'m> {
        let rest = |name: &str| Some(name.strip_prefix(stem)?.strip_prefix('_')?.to_string());
        self.ports.iter().filter_map(|(name, wire)| Some((rest(name)?, *wire))).collect()
    }
}

/// A name and a wire.
pub fn named<'m>(name: &str, wire: Wire<'m>) -> (String, Wire<'m>) {
    (name.to_string(), wire)
}

/// Wires with a stem before their names: `<stem>_<name>`.
pub fn prefixed<'m>(stem: &str, named: Named<'m>) -> Named<'m> {
    named.into_iter().map(|(name, wire)| (format!("{stem}_{name}"), wire)).collect()
}

/// An enable and an address of a memory.
pub type Access<'m> = (Wire<'m>, Wire<'m>);

/// Words in a memory, with a column for each: written at one port, and read by name at the other.
pub fn keep<'m>(name: &str, depth: u32, write: Access<'m>, words: Named<'m>, read: Access<'m>) -> Named<'m> {
    let parameters = UnitParameters { ram_latency: 1, parity: false, ..UnitParameters::default() };
    keep_of_step(parameters, name, depth, write, words, read).0
}

/// As [`keep`], in a memory that a step reads: with its latency, and whether what was read has a wrong parity.
pub fn keep_of_step<'m>(
    UnitParameters { ram_latency, parity: has_parity, .. }: UnitParameters,
    name: &str,
    depth: u32,
    write: Access<'m>,
    mut words: Named<'m>,
    read: Access<'m>,
) -> (Named<'m>, Option<Wire<'m>>) {
    let wires = |words: &[(String, Wire<'m>)]| words.iter().map(|(_, wire)| *wire).collect::<Vec<_>>();
    words.extend(has_parity.then(|| named("parity", parity(&wires(&words)))));
    let columns: Vec<(&str, u32)> = words.iter().map(|(name, wire)| (name.as_str(), wire.width())).collect();
    let memory = write.0.builder().memory(name, depth, &columns).latency(ram_latency);
    memory.write(write.0, write.1, &wires(&words));
    let found = memory.read(read.0, read.1);
    let error = has_parity.then(|| parity(&found));
    let names = words.into_iter().map(|(name, _)| name).take(found.len() - usize::from(has_parity));
    (names.zip(found).collect(), error)
}

/// Whether these words have an odd number of ones.
pub fn parity<'m>(words: &[Wire<'m>]) -> Wire<'m> {
    let mut width = words.iter().map(|word| word.width()).max().unwrap_or(1).next_power_of_two();
    let extended = words.iter().map(|word| word.extend(width));
    let mut all = extended.reduce(|a, b| a ^ b).unwrap_or(words[0]);
    while width > 1 {
        width /= 2;
        all = all.upper(width) ^ all.lower(width);
    }
    all
}

/// A register that takes `wire` in every cycle.
pub fn delay<'m>(name: &str, wire: Wire<'m>) -> Wire<'m> {
    let register = wire.builder().register(name, wire.width());
    register.next(wire);
    register.wire()
}

/// A chain of registers that take `wire` in every cycle; `name` is the last, and `<name>_1_q` the first of several. The
/// others have the same reset value, if there is one.
pub fn delay_by<'m>(cycles: u32, name: &str, wire: Wire<'m>, reset: Option<u64>) -> Wire<'m> {
    (1..=cycles).fold(wire, |wire, cycle| {
        let name =
            if cycle == cycles { name.to_string() } else { format!("{}_{cycle}_q", name.trim_end_matches("_q")) };
        let register = wire.builder().register(&name, wire.width());
        let register = reset.map_or(register, |value| register.reset_to(value));
        register.next(wire);
        register.wire()
    })
}

/// A register that takes `wire` where `enable` is 1.
pub fn hold<'m>(name: &str, enable: Wire<'m>, wire: Wire<'m>) -> Wire<'m> {
    let register = wire.builder().register(name, wire.width());
    register.next_when(enable, wire);
    register.wire()
}
