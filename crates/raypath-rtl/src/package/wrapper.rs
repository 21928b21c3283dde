//! The wrapper and its package.

use super::Files;
use crate::DatapathNetlist;
use crate::package::fields::Field;
use crate::package::structures::Structures;
use crate::package::text::{columns, licensed, packed};
use raypath_hdl::Module;
use raypath_hdl::text::{Package, TextPort};
use raypath_hdl::verilog::{head, print_package};

/// A module with structures as ports, around one with flat ports. It has no logic.
pub struct Wrapper<'a> {
    top: &'a Module,
    /// The head comment.
    doc: Vec<String>,
    /// Its ports, those of a channel under a comment.
    channels: Vec<(Option<&'a str>, Vec<Port>)>,
}

/// A port of a wrapper.
enum Port {
    /// A port of the module.
    Flat(TextPort),
    /// Ports of the module as fields of the type `kind`.
    Structure { name: String, kind: String, is_input: bool, fields: Vec<Field> },
}

impl<'a> Wrapper<'a> {
    /// The wrapper of a datapath, with a job and an outcome.
    pub fn of_datapath(datapath: &'a DatapathNetlist) -> Self {
        let top = datapath.top();
        let mut flat = top.text_ports();
        let [input, output] = ["input_", "output_"].map(|prefix| take_handshake(&mut flat, prefix));
        let (job, outcome): (Vec<_>, Vec<_>) = flat.into_iter().partition(|port| port.is_input);
        let (job, outcome) =
            (Port::structure("job", "job", "", &job), Port::structure("outcome", "outcome", "", &outcome));
        let ports = clock().into_iter().chain(input).chain([job]).chain(output).chain([outcome]);
        let doc = vec![
            format!(
                "The module {} with structures as ports, without logic. Latency {}.",
                top.name(),
                datapath.latency()
            ),
            "A job enters if input_valid_i and input_ready_o are 1. An outcome is stable until it leaves, when \
             output_valid_o and output_ready_i are 1."
                .to_string(),
        ];
        Self { top, doc, channels: vec![(None, ports.collect())] }
    }

    /// The wrapper of a module whose text has ports in channels: each has valid, ready and a structure. `types` has the
    /// names of channels whose types have others.
    pub fn of_channels(top: &'a Module, types: &[(&str, &str)]) -> Self {
        let mut others = top.text_ports();
        let mut channels = Vec::new();
        for (prefix, comment) in &top.text().channels {
            let mut flat: Vec<TextPort> = others.extract_if(.., |port| port.name.starts_with(prefix)).collect();
            let mut ports = take_handshake(&mut flat, prefix);
            // A structure has one direction: that of valid.
            let is_input = matches!(ports.first(), Some(Port::Flat(TextPort { is_input: true, .. })));
            let (fields, flat): (Vec<_>, Vec<_>) = flat.into_iter().partition(|port| port.is_input == is_input);
            ports.extend(flat.into_iter().map(Port::Flat));
            let name = prefix.trim_end_matches('_');
            let kind = types.iter().find(|(channel, _)| *channel == name).map_or(name, |(_, kind)| kind);
            ports.extend((!fields.is_empty()).then(|| Port::structure(name, kind, prefix, &fields)));
            channels.extend((!ports.is_empty()).then_some((Some(comment.as_str()), ports)));
        }
        channels.insert(0, (None, clock().into_iter().chain(others.into_iter().map(Port::Flat)).collect()));
        let doc = vec![format!("The module {} with a structure for each channel, without logic.", top.name())];
        Self { top, doc, channels }
    }

    /// The files of the package and of the module, in the order of compilation.
    pub fn files(&self, banner: &[String]) -> Files {
        let name = self.top.name();
        vec![
            (format!("rtl/{name}_wrapper_pkg.sv").into(), self.package(banner)),
            (format!("rtl/{name}_wrapper.sv").into(), self.module(banner)),
        ]
    }

    /// The package of the structures. Opcodes are in the package of the datapath.
    fn package(&self, banner: &[String]) -> String {
        let name = self.top.name();
        let structures = self.ports().filter_map(|port| match port {
            Port::Structure { kind, fields, .. } => Some((kind.as_str(), fields.as_slice())),
            Port::Flat(_) => None,
        });
        let doc = format!(
            "The inputs and outputs of {name}_wrapper as structures. Their fields are the ports of the module {name}, \
             grouped by the words of their names. Numbers are encoded as at the ports."
        );
        let package = Package {
            name: format!("{name}_wrapper_pkg"),
            doc: vec![doc],
            enumerations: Vec::new(),
            structures: Structures::new(&structures.collect::<Vec<_>>()).types,
        };
        print_package(&package, &licensed(banner))
    }

    fn module(&self, banner: &[String]) -> String {
        let name = self.top.name();
        let declarations = columns("  ", &self.ports().map(|port| port.declaration(name)).collect::<Vec<_>>());
        let mut declarations = declarations.into_iter();
        let mut ports = Vec::new();
        for (comment, of_channel) in &self.channels {
            ports.extend(comment.map(|comment| format!("  // {comment}")));
            ports.extend(declarations.by_ref().take(of_channel.len()));
        }
        let mut wires = Vec::new();
        for port in self.ports() {
            match port {
                Port::Flat(TextPort { name, .. }) => wires.push((name.clone(), name.clone())),
                Port::Structure { name, fields, .. } => connect(fields, name, &mut wires),
            }
        }
        let wires: Vec<_> = wires.iter().map(|(port, wire)| (format!(".{port}"), format!("({wire})"))).collect();
        format!(
            "{}module {name}_wrapper (\n{}\n);\n\n  {name} u_{name} (\n{}\n  );\n\nendmodule : {name}_wrapper\n",
            head(banner, &self.doc),
            ports.join("\n").trim_end_matches(','),
            columns("    ", &wires).join(",\n"),
        )
    }

    fn ports(&self) -> impl Iterator<Item = &Port> {
        self.channels.iter().flat_map(|(_, ports)| ports)
    }
}

impl Port {
    /// Ports, whose names begin with `prefix`, as a structure.
    fn structure(name: &str, kind: &str, prefix: &str, ports: &[TextPort]) -> Self {
        let is_input = ports.iter().all(|port| port.is_input);
        let name = format!("{name}_{}", if is_input { "i" } else { "o" });
        Self::Structure { name, kind: format!("{kind}_t"), is_input, fields: Field::of(ports, prefix) }
    }

    /// Direction and type, and the name, in the wrapper of the module `top`.
    fn declaration(&self, top: &str) -> (String, String) {
        let (kind, name, is_input) = match self {
            Self::Flat(TextPort { name, width, is_input }) => (packed(*width), name, is_input),
            Self::Structure { name, kind, is_input, .. } => (format!("{top}_wrapper_pkg::{kind}"), name, is_input),
        };
        (format!("{} {kind}", if *is_input { "input " } else { "output" }), format!("{name},"))
    }
}

/// Clock and reset.
fn clock() -> [Port; 2] {
    ["clk_i", "rst_ni"].map(|name| Port::Flat(TextPort { name: name.to_string(), width: 1, is_input: true }))
}

/// Removes the handshake of a channel: valid, then ready.
fn take_handshake(ports: &mut Vec<TextPort>, prefix: &str) -> Vec<Port> {
    let mut take = |name: &str| {
        let place = ports.iter().position(|port| port.stem() == format!("{prefix}{name}"))?;
        Some(Port::Flat(ports.remove(place)))
    };
    ["valid", "ready"].into_iter().filter_map(&mut take).collect()
}

/// Every port below `fields`, and the field that it is connected to.
fn connect(fields: &[Field], path: &str, wires: &mut Vec<(String, String)>) {
    for field in fields {
        let path = format!("{path}.{}", field.name());
        match field {
            Field::Port { port, .. } => wires.push((port.clone(), path)),
            Field::Group { fields, .. } => connect(fields, &path, wires),
        }
    }
}
